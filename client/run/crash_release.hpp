#pragma once
// Releases the device when the program crashes.

#include "client/devices/device.hpp"

namespace feltwire {

/// While it lives, a signal that kills the program (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT and so
/// std::terminate(), SIGSYS, SIGTRAP, SIGXCPU, SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2) first
/// releases the device; then the program ends by the signal as usual. Signals that stop a program
/// from its terminal (SIGTSTP, SIGTTIN, SIGTTOU) and SIGXFSZ are ignored meanwhile, because a
/// stopped program would hold its last force. No program can react to SIGKILL, SIGSTOP, a stack
/// overflow, or a failure of the machine: only the device's own watchdog can.
///
/// Only one may exist in a program.
class CrashRelease {
 public:
  /// `records`: SIGUSR1 asks for a flight record (Signals), and kills nothing.
  explicit CrashRelease(Device& device, bool records = false) noexcept;
  ~CrashRelease();
  CrashRelease(const CrashRelease&) = delete;
  CrashRelease& operator=(const CrashRelease&) = delete;

 private:
  bool records_;
};

}  // namespace feltwire
