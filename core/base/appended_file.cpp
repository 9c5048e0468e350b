#include "core/base/appended_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace feltwire {
namespace {

/// Removes all access rights of the group and of other users, also from an existing file. Leaves a
/// pipe or a device unchanged. Returns false and sets errno if the system refuses.
bool keep_private(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return false;
  const mode_t mode = status.st_mode & (S_IRWXU | S_IRWXG | S_IRWXO);
  if (!S_ISREG(status.st_mode) || (mode & (S_IRWXG | S_IRWXO)) == 0) return true;
  return ::fchmod(descriptor, mode & S_IRWXU) == 0;
}

}  // namespace

AppendedFile::AppendedFile(std::filesystem::path file, std::string what, const std::string& option)
    : file_(std::move(file)), what_(std::move(what)) {
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (descriptor_ < 0)
    throw std::runtime_error("cannot write " + what_ + " " + file_.string() + ": " +
                             std::strerror(errno) + "; check the path in " + option);
  if (keep_private(descriptor_)) return;
  const std::string reason = std::strerror(errno);
  ::close(descriptor_);
  throw std::runtime_error("cannot write " + what_ + " " + file_.string() +
                           ": other users can read it, and it cannot be closed to them: " + reason +
                           "; remove it, or choose another path in " + option);
}

AppendedFile::~AppendedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void AppendedFile::append(std::string_view piece, Whole whole) {
  std::size_t done = 0;
  while (done < piece.size()) {
    const ssize_t written = ::write(descriptor_, piece.data() + done, piece.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int error = errno;
      // Cut off the incomplete end of `piece`, because it would make the whole file unreadable. For
      // a pipe, ftruncate() fails.
      size_ += static_cast<std::int64_t>(whole(piece.substr(0, done)));
      while (::ftruncate(descriptor_, size_) != 0 && errno == EINTR) {
      }
      fail(error);
    }
    done += static_cast<std::size_t>(written);
  }
  size_ += static_cast<std::int64_t>(piece.size());
}

void AppendedFile::finish() {
  const int descriptor = std::exchange(descriptor_, -1);
  // Ignore EINVAL and EROFS. These errors come from files that are not on a disk and need no
  // synchronization.
  const bool lost = ::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS;
  int error = lost ? errno : 0;
  if (::close(descriptor) != 0 && error == 0 && errno != EINTR) error = errno;
  if (error != 0) fail(error);
}

void AppendedFile::fail(int error) {
  throw std::runtime_error(what_ + " " + file_.string() + " ends here: " + std::strerror(error) +
                           "; make room on its disk, or choose another path");
}

}  // namespace feltwire
