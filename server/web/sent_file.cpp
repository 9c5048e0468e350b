#include "server/web/sent_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace feltwire::web {
namespace {

[[noreturn]] void fail(int error) {
  throw std::system_error(error, std::generic_category(), "a file to send");
}

}  // namespace

SentFile::SentFile(const std::filesystem::path& path) {
  // Without O_NONBLOCK the call would wait for the other end of a pipe.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor_ < 0) fail(errno);
  struct stat about {};
  const int error = ::fstat(descriptor_, &about) != 0 ? errno : 0;
  if (error == 0 && S_ISREG(about.st_mode)) {
    size_ = static_cast<std::uint64_t>(about.st_size);
    return;
  }
  ::close(descriptor_);
  fail(error != 0 ? error : EINVAL);
}

SentFile::~SentFile() { ::close(descriptor_); }

std::vector<std::uint8_t> SentFile::next() {
  std::vector<std::uint8_t> piece(std::min<std::uint64_t>(kPiece, size_ - read_));
  if (piece.empty()) return piece;
  ssize_t count = -1;
  do count = ::read(descriptor_, piece.data(), piece.size());
  while (count < 0 && errno == EINTR);
  if (count <= 0) fail(count < 0 ? errno : EIO);
  piece.resize(static_cast<std::size_t>(count));
  read_ += piece.size();
  return piece;
}

}  // namespace feltwire::web
