#pragma once
// A simulated arm in a simulation that somebody else steps: its controller, the sensor in its wrist
// and its protective stop.

#include <cstdint>
#include <memory>
#include <string>

#include "core/teleoperation/arm_control.hpp"
#include "core/teleoperation/follower.hpp"

struct mjModel_;
struct mjData_;

namespace feltwire {

/// The MJCF file names the parts of the arm, all with the prefix of the ArmControl: the hinge
/// joints joint1 to joint7 and, for a gripper, the slide joints finger1 and finger2, each with
/// limits and a <motor> whose ctrlrange is its torque or force limit; the sites `tool` (where
/// targets act), `wrist` (the sensor) and `balance` (the centre of mass of the tool), all in one
/// body; the sensors wrist_force, wrist_torque at `wrist` and tool_acceleration (accelerometer) at
/// `balance`; the numeric `home` of seven angles [rad], where the arm begins. scenes/arm/arm.xml is
/// one.
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
/// subtracted, then noise is added: normal, and in length at most spec().wrench_noise. Above
/// stop_force or stop_torque the arm stops: it holds its place until resume().
///
/// A step of the simulation calls spread(), drive(), mj_step2(), weigh(), mj_step1(), judge() and
/// read(), in this order. It allocates only at construction.
class DrivenArm {
 public:
  /// `data` is evaluated (mj_step1) with the arm at home. The model must outlive it. Throws
  /// FileError that names `file`, the missing or wrong part, and the remedy. Precondition: check()
  /// finds no violation in `control`, and servo_period > 0 [s].
  DrivenArm(const ArmControl& control, double servo_period, const std::string& file,
            const mjModel_& model, const mjData_& data);
  ~DrivenArm();
  DrivenArm(DrivenArm&&) noexcept;
  DrivenArm& operator=(DrivenArm&&) noexcept;

  const FollowerSpec& spec() const noexcept;

  /// Takes a finite target, shortened to largest_pull / K and largest_turn / turning_stiffness
  /// about the tool; a stopped or faulty arm takes none. Returns the target that it holds.
  const FollowerTarget& aim(const FollowerTarget& target, const mjData_& data) noexcept;
  const FollowerTarget& target() const noexcept;
  /// The target is the tool's place from now on.
  void hold(const mjData_& data) noexcept;

  /// Divides the movement of the target since the last call among the next `steps`.
  void spread(int steps) noexcept;
  /// Sets the motors. False: MuJoCo failed.
  bool drive(mjData_& data) noexcept;
  /// Takes the wrench from the sensors. False: it is not finite.
  bool weigh(const mjData_& data) noexcept;
  /// Stops the arm if the wrench is too large. `done`: the step succeeded, and weigh() did; the
  /// reading is ok only then.
  void judge(bool done, const mjData_& data) noexcept;
  /// The reading; `n` numbers the noise.
  const FollowerReading& read(const mjData_& data, std::uint64_t n) noexcept;
  /// The last one.
  const FollowerReading& reading() const noexcept;

  /// Whether the force and the torque on the tool are below half of what stops the arm.
  bool is_calm() const noexcept;
  /// Ends a protective stop.
  void resume() noexcept;
  /// The simulation was put back to an older state: the arm holds its place there, and feels
  /// nothing.
  void put_back(const mjData_& data) noexcept;

  /// For tests and studies.
  struct Inside;
  const Inside& inside() const noexcept { return *inside_; }

 private:
  std::unique_ptr<Inside> inside_;
};

/// Puts the arm of that prefix to its home in `coordinates` (qpos). Throws FileError as the
/// constructor does.
void go_home(const mjModel_& model, const std::string& file, const ArmControl& control,
             double* coordinates);

}  // namespace feltwire
