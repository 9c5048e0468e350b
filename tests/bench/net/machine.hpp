#pragma once
// The parts of the machine that the load program uses: cores, clocks, and a socket of the loopback.

#include <sys/types.h>

#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire::netbench {

/// The calling thread, and what it starts from now on, runs on this core only. Throws
/// std::system_error.
void pin_to(int core);
int cores() noexcept;

/// Of the monotonic clock.
Nanoseconds now() noexcept;
/// CPU time that a process has used so far, in all its threads.
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
  /// Receiving without an answer for so long ends.
  void set_patience(Nanoseconds time) const;

 private:
  int file_;
};

}  // namespace feltwire::netbench
