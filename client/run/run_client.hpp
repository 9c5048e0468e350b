#pragma once
// Runs a device in a scene of a server, from joining to the report. The program of a device maker
// needs only this call.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/device/device.hpp"
#include "client/device/protected_device.hpp"
#include "client/hands/true_energy.hpp"
#include "client/run/observer_recorder.hpp"
#include "client/run/recording.hpp"
#include "client/run/run_figures.hpp"
#include "client/servo/servo.hpp"
#include "client/transport/control_client.hpp"
#include "client/transport/datagram_port.hpp"

namespace feltwire {

/// The longest time of a request to the server.
inline constexpr std::chrono::milliseconds kControlTimeout{3000};

/// How long a force may stay on the hand.
struct HoldOptions {
  /// The hold time is lengthened if the servo period of the device needs it (choose_hold_time()).
  bool follows_period = false;
  /// [s] While a force is on the hand, the device is let go for good if no tick comes for this
  /// time. 0: the usual time (let_go_time()).
  double let_go_after = 0.0;
  /// [s] The longest hold_time that the server may grant; 0: no longer than was asked for.
  double longest = 0.0;
};

/// The files that a run writes.
struct RunFiles {
  std::optional<std::filesystem::path> report, record, view;  // files to write; empty: none
  RecordingLimits record_limits;                              // of each file of an MCAP recording
  /// Folder for the last ten seconds before an error that ends the run, a lost session, a device
  /// fault, an overdrawn account, or SIGUSR1; empty: none, and SIGUSR1 ends the program.
  std::optional<std::filesystem::path> flight_recorder;
  /// False: if the folder cannot be made, a warning is printed, and the run goes on without it.
  bool flight_recorder_required = true;
};

/// The functions of the program that a run calls.
struct RunHooks {
  /// For an observer: called for each view, by the thread that called run_client(). If
  /// it throws, it is not called again; the run goes on, and returns 1.
  OnView on_view = {};
  /// Gets every tick, in the servo thread; it must outlive the run. Null: nobody does.
  TickListener* listener = nullptr;
  /// Called with the measurements of the run, after the servo thread has ended. The text that it
  /// returns (JSON) is the report's `check`. If it throws, the report fails.
  std::function<std::string(const RunFigures&)> on_end = {};
  /// Called last, with the exit code, also where a thread could not be waited for and the program
  /// must end at once, so that run_client() does not return. Returns the exit code to use. Must not
  /// throw.
  std::function<int(int code)> on_exit = {};
  /// The energy at the true ends of a simulated device, for the report; empty: not known. Called
  /// while the device lives, after the servo thread has ended.
  std::function<TrueEnergy()> true_energy = {};
  /// Opens the port for datagrams to the scene; empty: open_udp_port(). May throw SessionError.
  std::function<std::unique_ptr<DatagramPort>(const Address& scene)> open_port = {};
  /// Joins the scene; empty: asks `server`. May throw SessionError.
  std::function<Joined(const control::JoinRequest& request)> join = {};
};

/// The options of one run. docs/devices.md explains them as options of feltwire-client.
struct RunOptions {
  ServerAccess server;                   // the server's address, and the credentials
  std::string name = "feltwire-client";  // of this client, for the server's log and the report
  std::string scene;                     // the name of the scene to join
  std::string tool;                      // the name of the tool to hold; empty: the scene's first
  std::string robot;                     // the seat of the robot that it leads; empty: the first
  Role role = Role::operator_;           // or observer
  std::string device_kind;               // for the report
  SessionParameters parameters = usual_parameters();  // requested from the server
  /// The emergency stop of the ProtectedDevice: keys of the terminal press and reset it. Null: the
  /// terminal has no such keys.
  std::shared_ptr<EmergencyStop> emergency;
  ServoOptions servo;  // safety limits; protect_hand(parameters) gives the usual ones
  /// The changes that an admin may make while it runs (docs/admin.md); none by default.
  /// Never use LawsTaken::any if a person's hand may be at the device. A link is the one that
  /// `open_port` emulates.
  ChangesTaken takes = {};
  double duration = 0.0;   // [s] 0: until stopped
  double busy_poll = 0.0;  // [us] to poll for replies and deadlines; infinity: never sleep
  double patience = 30.0;  // [s] to look for a lost session; 0: not at all
  HoldOptions hold;
  RunFiles files;
  RunHooks hooks;
  /// Fetches the scene's meshes, or the tool's body with the solids, for the local model; false:
  /// the model has patches or planes of them only.
  bool whole_surfaces = true;
  /// Says beside the run what a hand will feel (client/run/rehearsal.hpp).
  bool rehearses = false;
};

/// Joins the scene and runs the servo loop in a thread of its own. The run ends when the duration
/// is over, a signal comes (SIGINT, SIGTERM, SIGQUIT, SIGHUP), the device has ended, or the session
/// is lost for good. Then it releases the hand, tells the server and writes the report. Status
/// lines go to stderr, the last line to stdout.
///
/// Returns the exit code for the program: 0, or 1 if the server ended the session or something
/// failed. Throws SessionError, std::runtime_error (a file cannot be written) or std::system_error
/// only before the device gets any force. If a thread hangs and cannot be joined, the call ends the
/// program with the exit code.
///
/// `device` must not be null. From the call on the process ignores SIGPIPE and SIGXFSZ and writes
/// no core dump, because a core dump would hold keys.
int run_client(std::unique_ptr<Device> device, const RunOptions& options);

}  // namespace feltwire
