#include "client/drivers/haply/serial_port.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

#include "protocol/net/clock.hpp"
#include "protocol/net/poll_until.hpp"

namespace feltwire {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& port, int error) {
  std::string remedy = "check the name; feltwire-client devices lists what is plugged in";
  if (error == EACCES)
    remedy = "join the group that ls -l shows (usually: sudo adduser $USER dialout), log in anew";
  if (error == EBUSY || error == EWOULDBLOCK)
    remedy = "another program holds it; feltwire-client devices says which";
  if (error == ENOTTY) remedy = "it is no serial port; give one, as /dev/ttyACM0";
  throw std::runtime_error("cannot open " + port.string() + ": " +
                           std::generic_category().message(error) + "; " + remedy);
}

/// Locks the port against other programs. TIOCEXCL does not stop a program of root. flock() stops
/// it only if that program also locks the port.
bool keep(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && ::ioctl(descriptor, TIOCEXCL) == 0;
}

/// Sets 8 bits, no parity, one stop bit, no flow control. USB ignores the bit rate.
bool make_raw(int descriptor) {
  termios settings{};
  if (::tcgetattr(descriptor, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  ::cfsetspeed(&settings, B115200);
  return ::tcsetattr(descriptor, TCSANOW, &settings) == 0 && ::tcflush(descriptor, TCIOFLUSH) == 0;
}

bool would_wait() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

SerialPort::SerialPort(const std::filesystem::path& port)
    : descriptor_(::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (descriptor_ < 0) refuse(port, errno);
  if (keep(descriptor_) && make_raw(descriptor_)) return;
  const int error = errno;
  ::close(descriptor_);
  refuse(port, error);
}

SerialPort::~SerialPort() {
  // End the exclusive mode. Otherwise it would last until every user of the port has closed it.
  ::ioctl(descriptor_, TIOCNXCL);
  ::close(descriptor_);
}

std::optional<std::size_t> SerialPort::write(std::span<const std::uint8_t> bytes) const noexcept {
  const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
  if (written >= 0) return static_cast<std::size_t>(written);
  if (would_wait()) return 0;
  return std::nullopt;
}

std::optional<std::size_t> SerialPort::read(std::span<std::uint8_t> room) const noexcept {
  pollfd state{descriptor_, POLLIN, 0};
  ::poll(&state, 1, 0);
  if ((state.revents & POLLIN) != 0) {
    const ssize_t count = ::read(descriptor_, room.data(), room.size());
    if (count > 0) return static_cast<std::size_t>(count);
    if (count < 0 && would_wait()) return 0;
    return std::nullopt;  // ready but empty: the port was unplugged
  }
  if (state.revents != 0) return std::nullopt;
  return 0;
}

bool SerialPort::wait(Nanoseconds latest) const noexcept {
  return poll_until(descriptor_, POLLIN, latest);
}

}  // namespace feltwire
