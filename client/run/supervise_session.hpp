#pragma once
// The main thread's loop while the servo thread runs: status lines, records, reconnection, signals.

#include "client/run/changes.hpp"
#include "client/run/emergency_key.hpp"
#include "client/run/records.hpp"
#include "client/servo/servo_thread.hpp"
#include "client/transport/reconnector.hpp"
#include "client/transport/scene_fetch.hpp"

namespace feltwire {

/// SIGINT, SIGTERM, SIGHUP and SIGQUIT, which end the run, as a descriptor for the thread that
/// makes it. They are blocked in all threads that start from now on. A thread that began before
/// passes them on to that thread.
class Signals {
 public:
  /// `records`: also SIGUSR1, which requests a flight record. Throws std::system_error.
  explicit Signals(bool records = false);
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  int descriptor() const { return descriptor_; }
  /// The signals that came since the last call.
  struct PendingSignals {
    bool end = false, record = false;
  };
  PendingSignals take() const noexcept;

 private:
  bool records_;
  int descriptor_ = -1;
};

/// Runs until the servo thread's loop is over. It shows its status, writes the records, also on a
/// signal, handles changes of an admin, looks for a lost session, and ends the loop on a signal or
/// when another session is refused for good. A key of the terminal presses the emergency stop
/// (`keys`). It fetches the scene in full for `session`, the first one of the loop, and for those
/// after it (session 0: for none). No failure in here ends the run: a status line without memory is
/// not shown.
void supervise_session(const Signals& signals, ServoThread& thread, Ring<LiveStatus>& statuses,
                       Records& records, Changes& changes, Reconnector& reconnector,
                       SceneFetch& fetch, std::uint64_t session, EmergencyKey& keys) noexcept;

}  // namespace feltwire
