#pragma once
// Looks after a session while the servo thread runs.

#include <cstdint>
#include <string>

#include "client/run/changes.hpp"
#include "client/run/records.hpp"
#include "client/run/run_outlet.hpp"
#include "client/servo/servo_thread.hpp"
#include "client/transport/reconnector.hpp"
#include "client/transport/scene_fetch.hpp"

namespace feltwire {

/// A single thread makes it, and calls look() about every 50 ms.
class SessionSupervisor {
 public:
  struct Parts {
    ServoThread& thread;
    Ring<LiveStatus>& statuses;  // of that thread
    Records& records;
    Changes& changes;
    Reconnector& reconnector;
    SceneFetch& fetch;
  };

  /// `session`: the number of the first session, for which the scene is fetched in full; 0: for
  /// none. All parts and the outlet must outlive this.
  SessionSupervisor(const Parts& parts, std::uint64_t session, RunOutlet& outlet)
      : parts_(parts), session_(session), outlet_(outlet) {}

  /// Takes the outputs of the servo thread and writes them, handles changes of an admin, looks for
  /// a lost session, and fetches the scene. False: the servo loop is over. No failure in here ends
  /// the run: a status line without memory is not shown.
  bool look() noexcept;
  /// Asks the servo to release the hand and end. Does not wait.
  void stop() noexcept { parts_.thread.stop(); }
  /// Readable when the servo loop is over; use it only to wait.
  int over_descriptor() const noexcept { return parts_.thread.over_descriptor(); }
  /// Writes the last seconds to a file, and says which; nothing without a flight recorder.
  void write_flight_record(const char* cause) noexcept;

 private:
  void show(const LiveStatus& status) noexcept;
  void tell_of_changes() noexcept;
  void follow_session() noexcept;
  void tell_of_fetch() noexcept;

  Parts parts_;
  std::uint64_t session_;
  RunOutlet& outlet_;
  bool connected_ = true;
  std::string fetch_refusal_;  // the last one that was told
};

}  // namespace feltwire
