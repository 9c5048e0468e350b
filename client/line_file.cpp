#include "client/line_file.hpp"

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

LineFile::~LineFile() { ::close(descriptor_); }

void LineFile::put() {
  std::size_t done = 0;
  while (done < lines_.size()) {
    const ssize_t written = ::write(descriptor_, lines_.data() + done, lines_.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      lines_.clear();
      throw std::runtime_error(what_ + " " + file_.string() +
                               " ends here: " + std::strerror(errno));
    }
    done += static_cast<std::size_t>(written);
  }
  lines_.clear();
}

}  // namespace feltwire
