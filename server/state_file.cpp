#include "server/state_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "core/scene/json_document.hpp"

namespace feltwire {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file) {
  throw FileError(file.string() + ": cannot be written: " + std::strerror(errno) +
                  "; check the folder and your right to write there");
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

void write_state(const std::filesystem::path& file, std::string_view text, mode_t mode) {
  std::string name = file.string() + ".XXXXXX";
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);  // for its owner alone, whatever comes
  if (descriptor < 0) fail(file);
  const bool written =
      ::fchmod(descriptor, mode) == 0 && write_all(descriptor, text) && ::fsync(descriptor) == 0;
  const int error = errno;
  ::close(descriptor);
  if (written && ::rename(name.c_str(), file.c_str()) == 0) return;
  if (!written) errno = error;
  const int reason = errno;
  ::unlink(name.c_str());
  errno = reason;
  fail(file);
}

FileLock::FileLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kPrivate)) {
  if (descriptor_ < 0) fail(file);
  while (::flock(descriptor_, LOCK_EX) != 0) {
    if (errno == EINTR) continue;
    const int reason = errno;
    ::close(descriptor_);
    errno = reason;
    fail(file);
  }
}

FileLock::~FileLock() { ::close(descriptor_); }

}  // namespace feltwire
