#pragma once
// Lets the device go when the program crashes.

#include "client/devices/device.hpp"

namespace feltwire {

/// While it lives, a signal that kills the program (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT and so
/// std::terminate(), SIGSYS, SIGTRAP, SIGXCPU, SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2) first
/// releases the device; then the program ends by it as it would have. Signals that stop a program
/// from its terminal (SIGTSTP, SIGTTIN, SIGTTOU) and SIGXFSZ are ignored meanwhile: stopped, it
/// would hold its last force. Nothing in the program can do anything about SIGKILL, SIGSTOP, a
/// stack that overflowed, or the machine: only the device's own watchdog can.
///
/// One at a time in a program.
class CrashRelease {
 public:
  explicit CrashRelease(Device& device) noexcept;
  ~CrashRelease();
  CrashRelease(const CrashRelease&) = delete;
  CrashRelease& operator=(const CrashRelease&) = delete;
};

}  // namespace feltwire
