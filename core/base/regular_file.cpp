#include "core/base/regular_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/base/captured_files.hpp"
#include "core/base/file_error.hpp"

namespace feltwire {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int value() const { return value_; }

 private:
  int value_;
};

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

std::string size_text(std::size_t bytes) {
  constexpr std::size_t kKiB = 1024, kMiB = kKiB * kKiB;
  if (bytes >= kMiB) return std::to_string(bytes / kMiB) + " MiB";
  return bytes >= kKiB ? std::to_string(bytes / kKiB) + " KiB" : std::to_string(bytes) + " bytes";
}

}  // namespace

std::string read_regular_file(const std::filesystem::path& file, std::size_t most,
                              std::string_view remedy) {
  const auto fail = [&](const std::string& what) { throw FileError(file.string() + ": " + what); };
  const FileReading& reading = file_reading_of_this_thread;
  if (reading.given != nullptr) {
    const auto at = reading.given->find(captured_name(file));
    if (at == reading.given->end()) fail("is not among the files that were kept");
    return at->second;
  }
  // With O_NONBLOCK, opening a pipe does not wait for a writer. With O_NOCTTY, a terminal does not
  // become the controlling terminal of the program.
  const Descriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (in.value() < 0)
    fail(std::string("cannot be opened: ") + std::strerror(errno) + "; " + std::string(remedy));
  struct stat status {};
  if (::fstat(in.value(), &status) != 0)
    fail(std::string("cannot be read: ") + std::strerror(errno) + "; " + std::string(remedy));
  if (!S_ISREG(status.st_mode))
    fail(std::string("is ") + kind_of(status.st_mode) + "; name a regular file");
  const auto too_large = [&] {
    fail("is larger than " + size_text(most) + "; is it the right file?");
  };
  if (status.st_size > 0 && static_cast<std::uintmax_t>(status.st_size) > most) too_large();

  // The size is only a first guess, because files of the kernel (such as /proc) report size 0.
  constexpr std::size_t kBlock = 65536;
  std::string text(std::min(most, static_cast<std::size_t>(status.st_size)) + 1, '\0');
  std::size_t size = 0;
  while (true) {
    if (size == text.size()) text.resize(size + std::min(kBlock, most + 1 - size));
    const ssize_t read = ::read(in.value(), text.data() + size, text.size() - size);
    if (read < 0 && errno == EINTR) continue;
    if (read < 0) fail(std::string("could not be read to its end: ") + std::strerror(errno));
    if (read == 0) break;
    size += static_cast<std::size_t>(read);
    if (size > most) too_large();
  }
  text.resize(size);
  if (reading.keep != nullptr) reading.keep->insert_or_assign(captured_name(file), text);
  return text;
}

}  // namespace feltwire
