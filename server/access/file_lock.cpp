#include "server/access/file_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/pending_file.hpp"

namespace feltwire {

FileLock::FileLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kPrivate)) {
  if (descriptor_ < 0) cannot_write(file, std::strerror(errno));
  while (::flock(descriptor_, LOCK_EX) != 0) {
    if (errno == EINTR) continue;
    const int reason = errno;
    ::close(descriptor_);
    cannot_write(file, std::strerror(reason));
  }
}

FileLock::~FileLock() { ::close(descriptor_); }

}  // namespace feltwire
