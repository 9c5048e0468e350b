#pragma once
// The main thread of a program while its servo thread runs: signals and keys.

#include "client/run/emergency_key.hpp"
#include "client/run/session_supervisor.hpp"

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

/// Looks after a session until its servo loop is over. It ends the loop on a signal, and writes a
/// flight record on SIGUSR1. A key of the terminal presses the emergency stop (`keys`).
void supervise_session(const Signals& signals, SessionSupervisor& session, EmergencyKey& keys,
                       RunOutlet& outlet) noexcept;

}  // namespace feltwire
