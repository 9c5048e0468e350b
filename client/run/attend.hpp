#pragma once
// The main thread's loop while the servo thread runs: status lines, records, reconnection, signals.

#include "client/run/records.hpp"
#include "client/servo/servo_thread.hpp"
#include "client/transport/reconnector.hpp"

namespace feltwire {

/// SIGINT, SIGTERM, SIGHUP and SIGQUIT as a descriptor; blocked in all threads that are started
/// from now on.
class Signals {
 public:
  /// Throws std::system_error.
  Signals();
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  int descriptor() const { return descriptor_; }
  /// One came since the last call.
  bool take() const noexcept;

 private:
  int descriptor_ = -1;
};

/// Until the servo thread's loop is over: shows its status, writes the records, looks for a lost
/// session, and has the loop end on a signal or when another session is refused for good. Nothing
/// that fails in here ends the run: a status line that there is no memory for is not shown.
void attend(const Signals& signals, ServoThread& thread, Ring<LiveStatus>& statuses,
            Records& records, Reconnector& reconnector) noexcept;

}  // namespace feltwire
