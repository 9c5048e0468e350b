#pragma once
// The loop of a robot that follows: it reads the robot, sends its state, takes targets and writes
// them.

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "client/transport/control_client.hpp"
#include "client/transport/datagram_port.hpp"
#include "core/teleoperation/follower.hpp"
#include "core/teleoperation/follower_servo.hpp"

namespace feltwire {

enum class FollowerEnd : std::uint8_t {
  requested,  // stop was set, or the duration is over
  lost,       // the session was lost, and none was found again in time
  evicted,    // the server ended the session, and no other was requested
};

struct FollowerRun {
  ServerAccess server{};                   // the server's address and the credentials
  std::string name = "feltwire-follower";  // of this robot, for the server's log
  std::string scene{};                     // the scene with the robot's seat
  std::string seat{};                      // the name of the seat; empty: the scene's only one
  FollowerOptions options{};
  double duration = 0.0;   // [s] 0: until stopped
  double patience = 30.0;  // [s] to look for a lost session; 0: not at all
  /// Opens the port for datagrams to the scene; empty: open_udp_port(). May throw SessionError.
  std::function<std::unique_ptr<DatagramPort>(const Address& scene)> open_port = {};
  /// Called by the loop's thread when the robot has its seat.
  std::function<void()> on_join = {};
  /// Called by the loop's thread when a session is lost, or the server ended it.
  std::function<void(FollowerEnd)> on_loss = {};
  /// Called by the loop's thread after each sample with the sent state and the newest target (index
  /// 0: none yet). It must not block, allocate or throw.
  std::function<void(const RobotState&, const RobotTarget&)> on_sample = {};
};

struct FollowerResult {
  FollowerEnd end = FollowerEnd::requested;
  FollowerStatistics statistics;
  std::uint64_t sessions = 0;  // number of sessions
  std::uint64_t overruns = 0;  // samples that came a whole period late or more
  double duration = 0.0;       // [s] from the beginning to the last sample
  double faulty_for = 0.0;     // [s] at its end, in which the robot gave no usable state
  /// Whether the robot was faulty at the end, and not only for a moment.
  bool robot_failed() const { return faulty_for >= kFaulty; }
  static constexpr double kFaulty = 0.25;  // [s]
  std::string refusal = {};  // why the server did not take the robot again; empty: it did not say
};

/// Joins as follower and runs the robot at its servo rate in the calling thread, until `stop` is
/// set or the session is lost for good. Samples have deadlines start + n T; missed ones are passed
/// over. A lost session is requested again, once a second for `patience`; meanwhile the robot
/// holds. At the end it brakes, holds (Follower::hold), and says goodbye.
///
/// Throws SessionError if the first session is refused or not available, std::invalid_argument if
/// the robot's numbers or the limits are not possible.
FollowerResult run_follower(Follower& robot, const FollowerRun& run, const std::atomic<bool>& stop);

}  // namespace feltwire
