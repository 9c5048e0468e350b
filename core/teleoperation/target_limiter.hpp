#pragma once

#include <cstdint>

#include "core/base/types.hpp"

namespace feltwire {

struct TargetLimits {
  double stiffness = 1000.0;  // K [N/m] of the robot's own controller, > 0
  double speed = 0.25;        // [m/s]
  double leash = 20.0;        // [N] largest force of the controller's spring
  double first_touch = 3.0;   // [N] while the hand does not know of the contact
  double unfelt = 3.0;        // [N] force that the hand need not have paid for
};

/// The target of a robot's impedance controller, from the leader's wanted place. In this order:
///  1. speed: the target moves by at most speed x elapsed.
///  2. first touch: in a contact that the leader's newest sample does not know, the spring holds at
///     most first_touch.
///  3. felt: in contact the spring's force K |e|, e = target - robot, rises only to
///       unfelt + sqrt(2 K paid)
///     `paid` is the work that the hand paid in this contact, less the work that forces above
///     `unfelt` did on the environment. The hand's work is a total in the sample, so a lost sample
///     loses nothing. `paid` is never below zero, so an impact leaves no debt. So the work on the
///     environment is at most the work that the hand paid, `unfelt` per metre of the tool's way,
///     and the robot's own kinetic energy (docs/teleoperation.md).
///  4. leash: |e| <= leash / K.
/// If a limit refuses a target, the last target stays, shortened towards the robot as the limit
/// requires: the limits hold for every message of the leader. A wanted place that is not finite
/// changes nothing.
///
/// No function allocates, throws after construction or reads a clock.
class TargetLimiter {
 public:
  /// Throws std::invalid_argument that names the limit and the remedy.
  explicit TargetLimiter(const TargetLimits& limits);

  struct Sample {
    Vec3 wanted = Vec3::Zero();  // [m] from the leader's newest sample
    Vec3 robot = Vec3::Zero();   // [m] the present place of the tool
    Vec3 force = Vec3::Zero();   // [N] of the environment on it
    std::uint32_t surface = 0;   // number of the surface that the robot touches; 0: none
    std::uint32_t known = 0;     // greatest number of those that the leader's newest sample knows
    double hand_work = 0.0;      // [J] total work that the hand paid since the session began
    double elapsed = 1e-3;       // [s]
  };
  /// Returns the target until the next sample [m]. The first call uses the robot's own position.
  const Vec3& step(const Sample& sample) noexcept;

 private:
  void account(const Sample& sample) noexcept;

  TargetLimits limits_;
  Vec3 target_ = Vec3::Zero();
  bool begun_ = false, touched_ = false;
  double work_seen_ = 0.0;     // [J]
  double paid_ = 0.0;          // [J] the rest in this contact
  Vec3 robot_ = Vec3::Zero();  // [m] place in the last step
};

}  // namespace feltwire
