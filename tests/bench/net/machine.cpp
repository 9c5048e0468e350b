#include "tests/bench/net/machine.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <system_error>
#include <thread>

namespace feltwire::netbench {
namespace {

void require(bool good, const char* what) {
  if (!good) throw std::system_error(errno, std::generic_category(), what);
}

Nanoseconds read_clock(clockid_t clock) noexcept {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + Nanoseconds(time.tv_nsec);
}

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

}  // namespace

void pin_to(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(core, &set);
  require(sched_setaffinity(0, sizeof set, &set) == 0, "sched_setaffinity");
}

int cores() noexcept { return static_cast<int>(std::thread::hardware_concurrency()); }

Nanoseconds now() noexcept { return read_clock(CLOCK_MONOTONIC); }

Nanoseconds cpu_time(pid_t process) {
  clockid_t clock{};
  if (const int error = clock_getcpuclockid(process, &clock); error != 0)
    throw std::system_error(error, std::generic_category(), "clock_getcpuclockid");
  return read_clock(clock);
}

Socket::Socket() : file_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  require(file_ >= 0, "socket");
  constexpr int kBuffer = 1 << 20;  // [bytes] as in the server
  ::setsockopt(file_, SOL_SOCKET, SO_RCVBUF, &kBuffer, sizeof kBuffer);
  const sockaddr_in address = loopback(0);
  require(::bind(file_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0, "bind");
}

Socket::~Socket() {
  if (file_ >= 0) ::close(file_);
}

std::uint16_t Socket::port() const {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  require(::getsockname(file_, reinterpret_cast<sockaddr*>(&address), &size) == 0, "getsockname");
  return ntohs(address.sin_port);
}

void Socket::connect(std::uint16_t port) const {
  const sockaddr_in address = loopback(port);
  require(::connect(file_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0,
          "connect");
}

void Socket::set_patience(Nanoseconds time) const {
  const timeval patience{0, std::chrono::duration_cast<std::chrono::microseconds>(time).count()};
  require(::setsockopt(file_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) == 0,
          "SO_RCVTIMEO");
}

}  // namespace feltwire::netbench
