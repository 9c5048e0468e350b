#pragma once
// The main thread's loop while the servo thread runs: status lines, records, reconnection, signals.

#include "client/run/changes.hpp"
#include "client/run/emergency_key.hpp"
#include "client/run/records.hpp"
#include "client/servo/servo_thread.hpp"
#include "client/transport/reconnector.hpp"

namespace feltwire {

/// SIGINT, SIGTERM, SIGHUP and SIGQUIT, which end the run, as a descriptor; blocked in all threads
/// that are started from now on.
class Signals {
 public:
  /// `records`: likewise SIGUSR1, which asks for a flight record. Throws std::system_error.
  explicit Signals(bool records = false);
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  int descriptor() const { return descriptor_; }
  /// The signals that came since the last call.
  struct Taken {
    bool end = false, record = false;
  };
  Taken take() const noexcept;

 private:
  int descriptor_ = -1;
};

/// Until the servo thread's loop is over: shows its status, writes the records, also those that a
/// signal asks for, deals with changes that an admin wants, looks for a lost session, and has the
/// loop end on a signal or when another session is refused for good. Nothing that fails in here
/// ends the run, and keys of the terminal stop the device at once (`keys`). A status line that
/// there is no memory for is not shown.
void attend(const Signals& signals, ServoThread& thread, Ring<LiveStatus>& statuses,
            Records& records, Changes& changes, Reconnector& reconnector,
            EmergencyKey& keys) noexcept;

}  // namespace feltwire
