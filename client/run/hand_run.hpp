#pragma once
// A device in a scene of a server: the session, the servo thread, and what keeps both going.

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "client/run/changes.hpp"
#include "client/run/crash_release.hpp"
#include "client/run/records.hpp"
#include "client/run/rehearsal.hpp"
#include "client/run/run_client.hpp"
#include "client/run/run_outlet.hpp"
#include "client/run/session_supervisor.hpp"
#include "client/servo/servo_thread.hpp"
#include "client/transport/reconnector.hpp"
#include "client/transport/scene_fetch.hpp"

namespace feltwire {

/// The data that the servo thread of a run shares with the thread that owns the run.
struct RunTask : ServoTask {
  using ServoTask::ServoTask;
  static constexpr std::size_t kSessionRoom = 4, kStatusRoom = 16;
  std::unique_ptr<Records> records;
  std::optional<Changes> changes;  // changes that an admin requests
  Ring<SessionAddress> sessions{kSessionRoom};
  Ring<LiveStatus> statuses{kStatusRoom};
  Ring<const FetchedScene*> fetched{kSessionRoom};
};

/// The metadata of the MCAP files of a run.
std::map<std::string, std::string> recording_about(const RunOptions& options);
/// The recording that the options ask for; empty: none.
std::optional<RecordingTarget> recording_target(const RunOptions& options);

/// A single thread makes a run, lets its supervisor look about every 50 ms, and calls end(). The
/// servo has a thread of its own. run_client() is for a program that does nothing else; a program
/// with a loop of its own makes a run itself.
class HandRun {
 public:
  /// Joins the scene, begins the device and starts the servo thread. `options` and `outlet` must
  /// outlive the run. `takes_sigusr1`: the program handles SIGUSR1 itself. Throws as run_client()
  /// does. The server is told of every failure after the join.
  HandRun(std::unique_ptr<Device> device, const RunOptions& options, RunOutlet& outlet,
          bool takes_sigusr1 = false);
  /// Calls end().
  ~HandRun();
  HandRun(const HandRun&) = delete;
  HandRun& operator=(const HandRun&) = delete;

  /// Looks after the run while it lasts.
  SessionSupervisor& supervisor() { return *supervisor_; }
  /// Calls stop(), waits, and completes the files. Returns the error that ended the run too early;
  /// empty: none did. A second call returns the same.
  const std::string& end();
  /// The servo thread has ended, and the device may be asked. False before end(). False afterwards:
  /// a call of the device does not return, and its thread still uses the run. The program should
  /// end at once.
  bool servo_ended() const { return ended_; }

  const control::JoinAccepted& accepted() const { return accepted_; }
  const Address& server() const { return datagrams_; }
  RealTime real_time() const { return real_time_; }
  const RunTask& task() const { return *task_; }
  const SceneFetch& fetch() const { return *fetch_; }
  /// Returns what a hand will feel. Empty: it was not computed, or not in time. Call it after
  /// end().
  std::optional<Rehearsal> rehearsal();

 private:
  void begin(std::unique_ptr<Device> device, control::JoinRequest& wanted,
             std::shared_ptr<Transport> transport);

  const RunOptions& options_;
  RunOutlet& outlet_;
  bool takes_sigusr1_;
  control::JoinAccepted accepted_;
  Address datagrams_;
  FleetRoute route_;
  std::string device_name_;  // among the devices of this process
  double owed_ = 0.0;        // [J] debt of that device at the start
  std::shared_ptr<RunTask> task_;
  std::optional<Reconnector> reconnector_;
  std::optional<SceneFetch> fetch_;
  std::optional<CrashRelease> crash_release_;
  std::optional<RehearsalThread> rehearsal_;
  std::optional<ServoThread> thread_;
  std::optional<SessionSupervisor> supervisor_;
  RealTime real_time_;
  std::optional<std::string> error_;  // of end()
  bool ended_ = false;
};

}  // namespace feltwire
