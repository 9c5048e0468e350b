#include "core/base/line_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace feltwire {

void append(std::string& line, double value) {
  constexpr int kDigits = 9;
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, kDigits)
                       .ptr;
  line.append(text.data(), end);
}

LineFile::LineFile(std::filesystem::path file, std::string what, const std::string& option,
                   std::string header)
    : file_(std::move(file)), what_(std::move(what)), lines_(std::move(header)) {
  constexpr int kForAll = 0644;
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kForAll);
  if (descriptor_ < 0)
    throw std::runtime_error("cannot write " + what_ + " " + file_.string() + ": " +
                             std::strerror(errno) + "; check the path in " + option);
  try {
    put();
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

LineFile::~LineFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void LineFile::put() {
  std::size_t done = 0;
  while (done < lines_.size()) {
    const ssize_t written = ::write(descriptor_, lines_.data() + done, lines_.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int error = errno;
      // A half line would make the whole file unreadable for a replay. (A pipe has none.)
      const std::size_t last = done > 0 ? lines_.rfind('\n', done - 1) : std::string::npos;
      if (last != std::string::npos) whole_ += static_cast<std::int64_t>(last) + 1;
      while (::ftruncate(descriptor_, whole_) != 0 && errno == EINTR) {
      }
      lines_.clear();
      fail(error);
    }
    done += static_cast<std::size_t>(written);
  }
  whole_ += static_cast<std::int64_t>(lines_.size());
  lines_.clear();
}

void LineFile::finish() {
  const int descriptor = std::exchange(descriptor_, -1);
  // Only a file on a disk can be synchronized, and needs to be.
  const bool lost = ::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS;
  int error = lost ? errno : 0;
  if (::close(descriptor) != 0 && error == 0 && errno != EINTR) error = errno;
  if (error != 0) fail(error);
}

void LineFile::fail(int error) {
  throw std::runtime_error(what_ + " " + file_.string() + " ends here: " + std::strerror(error) +
                           "; make room on its disk, or choose another path");
}

}  // namespace feltwire
