#include "core/base/pending_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/folder_names.hpp"

namespace feltwire {
namespace {

constexpr std::string_view kPart = ".part-";  // suffix in the name of the temporary file
constexpr std::size_t kDigits = 6;            // number of digits after kPart

/// Creates a new file beside `file`, and stores its path in `name`. Returns its descriptor, or -1
/// on an error.
int make_beside(const std::filesystem::path& file, mode_t mode, std::string& name) {
  for (int number = 0;; ++number) {
    std::string digits = std::to_string(number);
    if (digits.size() > kDigits) return -1;  // All names are in use, so errno is EEXIST.
    digits.insert(0, kDigits - digits.size(), '0');
    name = file.string() + std::string(kPart) + digits;
    const int made = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (made >= 0 || (errno != EEXIST && errno != EINTR)) return made;
  }
}

bool synchronize(int descriptor) {
  while (::fsync(descriptor) != 0)
    if (errno != EINTR) return false;
  return true;
}

/// Synchronizes the folder of a file with the disk. Ignores a failure, because some file systems
/// cannot do this.
void synchronize_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  synchronize(descriptor);
  ::close(descriptor);
}

}  // namespace

PendingFile::PendingFile(std::filesystem::path file, std::string_view text,
                         std::optional<mode_t> mode)
    : file_(std::move(file)) {
  if (std::error_code failed; std::filesystem::is_directory(file_, failed))
    cannot_write(file_, "it is a directory");
  if (is_special(file_)) cannot_write(file_, "it is not a regular file");
  // If a mode is given, create the file as private first. Otherwise another user could read the
  // file before it has this mode.
  const int descriptor = make_beside(file_, mode ? kPrivate : kPublic, written_);
  if (descriptor < 0) cannot_write(file_, std::strerror(errno));
  const bool written = (!mode || ::fchmod(descriptor, *mode) == 0) && write_all(descriptor, text) &&
                       synchronize(descriptor);
  int reason = written ? 0 : errno;
  // Some file systems report a full disk only at close().
  if (::close(descriptor) != 0 && reason == 0 && errno != EINTR) reason = errno;
  if (reason == 0) return;
  ::unlink(written_.c_str());
  cannot_write(file_, std::strerror(reason));
}

PendingFile::~PendingFile() {
  if (!written_.empty()) ::unlink(written_.c_str());
}

void PendingFile::put_in_place() {
  if (::rename(written_.c_str(), file_.c_str()) != 0) cannot_write(file_, std::strerror(errno));
  written_.clear();
  synchronize_folder(file_);
}

void replace_file(const std::filesystem::path& file, std::string_view text,
                  std::optional<mode_t> mode) {
  PendingFile(file, text, mode).put_in_place();
}

void remove_leftovers(const std::filesystem::path& file) {
  const std::string beginning = file.filename().string() + std::string(kPart);
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  for (const std::string& name : names_in(folder))
    if (name.size() == beginning.size() + kDigits && name.starts_with(beginning))
      ::unlink((folder / name).c_str());
}

bool is_special(const std::filesystem::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

void cannot_write(const std::filesystem::path& file, const char* reason) {
  throw FileError("cannot write " + file.string() + ": " + reason +
                  "; check the folder and your right to write there, or choose another path");
}

}  // namespace feltwire
