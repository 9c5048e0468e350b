#pragma once
// Releases the device when a signal ends the program.

#include <array>
#include <csignal>

#include "client/devices/device.hpp"

namespace feltwire {

/// While it lives, every signal that would end the program first releases the device, and gives a
/// driver's thread 20 ms to do so. Then the program ends by the signal as usual. These are the
/// crashes (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT and so std::terminate(), SIGSYS, SIGTRAP), and
/// of the others, real-time signals included, those that nothing handles. Signals that stop a
/// program from its terminal (SIGTSTP, SIGTTIN, SIGTTOU) and SIGXFSZ are ignored meanwhile, because
/// a stopped program would hold its last force. The two signals that the C library keeps to itself
/// (32 and 33) are ignored until it uses them. No program can react to SIGKILL, SIGSTOP, a stack
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
  static constexpr std::size_t kSignals = 65;  // 1 to 64
  std::array<struct sigaction, kSignals> before_{};
  std::array<bool, kSignals> taken_{};
};

}  // namespace feltwire
