#include "client/run/output_files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "core/base/pending_file.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

/// Identity of a file: its inode, or the inode of its folder and its name if the file does not
/// exist yet.
struct Place {
  dev_t device = 0;
  ino_t inode = 0;
  std::string name;
  bool operator==(const Place&) const = default;
};

/// Returns the identity of a file. Returns nothing for a pipe or a device, because several writers
/// may share it.
std::optional<Place> place_of(const fs::path& file) {
  const fs::path target = followed(file);
  struct stat status {};
  if (::stat(target.c_str(), &status) == 0) {
    if (!S_ISREG(status.st_mode)) return std::nullopt;
    return Place{status.st_dev, status.st_ino, {}};
  }
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (::stat(folder.c_str(), &status) == 0)
    return Place{status.st_dev, status.st_ino, target.filename().string()};
  std::error_code ignored;
  return Place{0, 0, fs::absolute(target, ignored).lexically_normal().string()};
}

void require_different(const NamedFile& a, const NamedFile& b, const char* harm) {
  const auto place = place_of(a.path);
  if (!place || place != place_of(b.path)) return;
  const std::string same =
      a.path == b.path ? a.path.string() : a.path.string() + " and " + b.path.string();
  throw std::invalid_argument(a.option + " and " + b.option + " name the same file, " + same +
                              "; " + harm + "; give another path");
}

int open_for_writing(const fs::path& file, int flags) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC | flags);
  if (descriptor < 0) cannot_write(file, std::strerror(errno));
  return descriptor;
}

}  // namespace

void require_different(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read) {
  for (std::size_t i = 0; i < written.size(); ++i) {
    for (std::size_t k = i + 1; k < written.size(); ++k)
      require_different(written[i], written[k], "one would overwrite the other");
    for (const NamedFile& source : read)
      require_different(written[i], source, "what is read would be overwritten");
  }
}

fs::path followed(const fs::path& file) {
  constexpr int kMostLinks = 40;  // same as the system's limit
  std::error_code error;
  fs::path target = file;
  for (int i = 0; i < kMostLinks && fs::is_symlink(target, error); ++i) {
    const fs::path next = fs::read_symlink(target, error);
    if (error) break;
    target = target.parent_path() / next;  // an absolute `next` replaces the path
  }
  fs::path whole = fs::weakly_canonical(target, error);
  return error ? target : whole;
}

void check_writable(const fs::path& file) {
  if (is_special(file)) {
    // O_NONBLOCK avoids the wait for a reader of a pipe.
    ::close(open_for_writing(file, O_NONBLOCK));
  } else {
    const PendingFile probe(followed(file), {}, kPrivate);
  }
}

void write_whole(const fs::path& file, std::string_view text) {
  if (!is_special(file)) return replace_file(followed(file), text, kPrivate);
  const int descriptor = open_for_writing(file, 0);
  const int reason = write_all(descriptor, text) ? 0 : errno;
  ::close(descriptor);
  if (reason != 0) cannot_write(file, std::strerror(reason));
}

}  // namespace feltwire
