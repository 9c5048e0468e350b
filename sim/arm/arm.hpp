#pragma once
// A simulated robot: a seven-axis arm with a gripper in MuJoCo, and the objects that it touches.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "client/followers/follower.hpp"
#include "core/base/types.hpp"

namespace feltwire {

struct ArmConfig {
  std::filesystem::path file;       // MJCF of the arm with its surroundings
  double servo_period = 1e-3;       // [s] of the spec, > 0
  double stiffness = 1000.0;        // K [N/m] > 0, every direction
  double turning_stiffness = 30.0;  // [N m/rad] > 0
  double damping_ratio = 1.0;       // > 0, by the tool's mass at home
  double posture_stiffness = 20.0;  // [N m/rad] >= 0 towards home, where the tool does not move
  double largest_pull = 30.0;       // [N] > 0 of the spring
  double largest_turn = 6.0;        // [N m] > 0 of the spring about the tool
  double stop_force = 60.0;         // [N] > 0: a protective stop above
  double stop_torque = 8.0;         // [N m] > 0: the same for torque
  double noise = 0.02;              // [N] >= 0 RMS of each axis of the wrist's sensor
  double torque_noise = 0.002;      // [N m] >= 0: the same for torque
  std::optional<double> gripper;    // [m] opening at the start; empty: open
  std::uint64_t seed = 1;           // of the noise
};

/// The arm. The file names its parts: the hinge joints joint1 to joint7 and, for a gripper, the
/// slide joints finger1 and finger2, each with limits and a <motor> whose ctrlrange is its torque
/// or force limit; the sites `tool` (where targets act), `wrist` (the sensor) and `balance` (the
/// centre of mass of the tool), all in one body; the sensors wrist_force, wrist_torque at `wrist`
/// and tool_acceleration (accelerometer) at `balance`; the numeric `home` of seven angles [rad],
/// where the arm begins. scenes/arm/arm.xml is one. A step is the file's timestep.
///
/// Each step the motors give, within their limits,
///   J^T (K e + B (w - v)) + gravity + walls at the joints' limits + posture
/// with e the vector to the target, in length at most largest_pull / K, and w the target's own
/// velocity, low-passed at 20 Hz and zero while the target is constant or the wrist feels more than
/// 1 N. The torque about the tool is computed in the same way. The posture acts in the null space
/// of the tool. The gripper's fingers are drawn to the target's opening by at most their motors'
/// force. Coriolis forces are not compensated, so that an arm with a constant target can give out
/// only the energy of its springs.
///
/// The sensor is in the wrist. The tool's weight and acceleration (from an accelerometer) are
/// subtracted, then noise is added: normal, and in length at most spec().wrench_noise.
///
/// A finite target is taken, and shortened to largest_pull / K and largest_turn / turning_stiffness
/// about the tool; write() returns the result. Above stop_force or stop_torque the arm stops: it
/// holds its place until resume().
///
/// Deterministic: the same config and calls give the same bits. Times are multiples of a step, from
/// the first read() on; a jump of more than 1 s is taken as 1 s. It allocates only at construction.
class Arm final : public Follower {
 public:
  /// Throws FileError if the file is not such an arm, std::invalid_argument if a number of the
  /// config cannot be used.
  explicit Arm(const ArmConfig& config);
  ~Arm() override;
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  const FollowerSpec& spec() const override { return spec_; }
  FollowerReading read(Nanoseconds now) noexcept override;
  FollowerTarget write(const FollowerTarget& target) noexcept override;
  void hold() noexcept override { held_.store(true); }

  /// Ends a protective stop. The thread of read() and write() calls it.
  void resume() noexcept;

  // For tests, studies and pictures; the thread of read() and write() calls them.
  /// [N] on the tool from now on, as if a person pushed it.
  void push(const Vec3& force) noexcept;
  /// [N] of the surroundings on the tool in the last step, as the simulation knows it.
  Vec3 contact_force() const noexcept;
  /// [J] energy of the arm: its springs and its movement.
  double energy() const noexcept;
  /// [rad] of an axis, 0 to 6; [N m] of its motor in the last step; its limits.
  double angle(int axis) const noexcept;
  double torque(int axis) const noexcept;
  struct Limits {
    double low, high, torque;
  };
  Limits limits(int axis) const noexcept;
  /// [m] place of a body of the file; empty: there is no such body.
  std::optional<Vec3> place_of(const std::string& body) const;

 private:
  struct Simulation;

  void step() noexcept;
  void sense() noexcept;
  void halt() noexcept;

  ArmConfig config_;
  FollowerSpec spec_;
  std::unique_ptr<Simulation> sim_;
  FollowerReading reading_;
  std::atomic<bool> held_{false};
  bool halted_ = false;  // by hold()
  bool begun_ = false;
  Nanoseconds start_{0};
  std::int64_t steps_ = 0;
};

/// Moves an arm at rest to `place` [m], straight, within 3 s, and lets it rest for 1 s. It keeps
/// the tool's orientation, and opens the gripper by `gripper` [m]. `now` is the time of its next
/// reading, and then that of its last one. Returns its last target.
FollowerTarget bring(Arm& arm, const Vec3& place, double gripper, Nanoseconds& now) noexcept;

}  // namespace feltwire
