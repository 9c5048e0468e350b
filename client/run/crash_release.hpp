#pragma once
// Releases the devices when a signal ends the program.

#include <cstddef>

#include "client/device/device.hpp"

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
/// A process may have several: each signal releases all their devices, and so does exit(). The
/// first one takes the signals, and the last one gives them back. A child process releases nothing,
/// because the devices are its parent's.
class CrashRelease {
 public:
  static constexpr std::size_t kMost = 64;  // in a process

  /// `takes_sigusr1`: the program handles SIGUSR1 itself (Signals), so it is left alone; the first
  /// one decides. Throws std::runtime_error if there are kMost already.
  explicit CrashRelease(Device& device, bool takes_sigusr1 = false);
  ~CrashRelease();
  CrashRelease(const CrashRelease&) = delete;
  CrashRelease& operator=(const CrashRelease&) = delete;

 private:
  std::size_t place_;
};

}  // namespace feltwire
