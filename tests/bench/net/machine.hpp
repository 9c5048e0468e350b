#pragma once
// The parts of the machine that the load program uses: cores, clocks, and a socket of the loopback.

#include <sys/types.h>

#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire::netbench {

/// From now on the calling thread, and the threads and processes that it starts, run on this core
/// only. Throws std::system_error.
void pin_to(int core);
int cores() noexcept;

/// The time of the monotonic clock.
Nanoseconds now() noexcept;
/// The CPU time that a process has used so far, in all its threads.
Nanoseconds cpu_time(pid_t process);

/// A UDP socket on 127.0.0.1.
class Socket {
 public:
  Socket();
  ~Socket();
  Socket(Socket&& other) noexcept : file_(other.file_) { other.file_ = -1; }
  Socket& operator=(Socket&&) = delete;

  int file() const { return file_; }
  std::uint16_t port() const;
  void connect(std::uint16_t port) const;
  /// Limits how long a receive call waits.
  void set_patience(Nanoseconds time) const;

 private:
  int file_;
};

}  // namespace feltwire::netbench
