#pragma once
// Limits of speed, acceleration and jerk for a moving target.

#include <algorithm>
#include <cmath>

#include "core/base/clamp_length.hpp"
#include "core/base/numeric.hpp"
#include "core/base/types.hpp"

namespace feltwire {

struct MotionLimits {
  double speed = 0.25;        // [m/s]
  double acceleration = 5.0;  // [m/s^2]
  double jerk = 500.0;        // [m/s^3]
  double turning = 1.0;       // [rad/s]
};

/// Follows a wanted place within the limits. It moves straight towards it, with the largest speed
/// from which half the acceleration can still brake:
///   v = min(speed - a^2 / (2 jerk), sqrt(a |d|), |d| / (4 a / jerk)),     d = wanted - here
/// Its velocity changes by at most a, its acceleration by at most the jerk. So it follows a jumping
/// place smoothly and a slow one closely, and it is v^2 / a behind a place that moves at v.
/// Rotation has only a limit of speed.
///
/// No function allocates, throws or reads a clock. If the wanted place is not finite, it brakes.
class MotionLimit {
 public:
  /// Precondition: all limits are finite and positive.
  explicit MotionLimit(const MotionLimits& limits)
      : limits_(limits),
        cruise_(std::max(
            0.5 * limits.speed,
            limits.speed - 0.5 * limits.acceleration * limits.acceleration / limits.jerk)) {}

  /// Sets the present place, at rest.
  void begin(const Pose& here) noexcept {
    here_ = here;
    velocity_.setZero();
    acceleration_.setZero();
  }

  /// Advances by one sample of `elapsed` [s] > 0.
  const Pose& follow(const Pose& wanted, double elapsed) noexcept {
    const Vec3 way = wanted.position - here_.position;
    const double distance = way.norm();
    if (!std::isfinite(distance) || !wanted.orientation.coeffs().allFinite()) return stop(elapsed);
    const double a = limits_.acceleration;
    const double fast =
        std::min({cruise_, std::sqrt(a * distance), distance * limits_.jerk / (kSettling * a)});
    const bool there = distance <= kThere && velocity_.norm() * elapsed <= kThere;
    steer(there || distance == 0.0 ? Vec3(Vec3::Zero()) : Vec3(way * (fast / distance)), elapsed);
    turn(wanted.orientation, elapsed);
    return here_;
  }

  /// Something else held it back: it is at `place` after the last sample of `elapsed` [s] > 0, and
  /// goes on from there with the velocity that it really had.
  void held_at(const Vec3& place, double elapsed) noexcept {
    velocity_ = clamp_length(velocity_ + (place - here_.position) / elapsed, limits_.speed);
    here_.position = place;
  }

  /// Brakes.
  const Pose& stop(double elapsed) noexcept {
    steer(Vec3::Zero(), elapsed);
    return here_;
  }

  const Pose& here() const noexcept { return here_; }
  const Vec3& velocity() const noexcept { return velocity_; }          // [m/s]
  const Vec3& acceleration() const noexcept { return acceleration_; }  // [m/s^2]

 private:
  static constexpr double kSettling = 4.0;  // times a / jerk: the time constant near the place
  static constexpr double kThere = 1e-9;    // [m]

  /// Moves towards a velocity. The acceleration is the largest one that the jerk can still reduce
  /// to zero by the time that this velocity is reached.
  void steer(const Vec3& velocity, double elapsed) noexcept {
    const Vec3 lacking = velocity - velocity_;
    const double gap = lacking.norm();
    const double step = limits_.jerk * elapsed;
    const double most = std::min({limits_.acceleration, gap / elapsed,
                                  std::max(step, std::sqrt(2.0 * limits_.jerk * gap) - step)});
    const Vec3 wanted = gap > 0.0 ? Vec3(lacking * (most / gap)) : Vec3(Vec3::Zero());
    acceleration_ += clamp_length(wanted - acceleration_, step);
    acceleration_ = clamp_length(acceleration_, limits_.acceleration);
    const Vec3 before = velocity_;
    velocity_ = clamp_length(velocity_ + acceleration_ * elapsed, limits_.speed);
    acceleration_ = (velocity_ - before) / elapsed;
    here_.position += velocity_ * elapsed;
  }
  void turn(const Quaternion& wanted, double elapsed) noexcept {
    const Vec3 way = rotation_between(here_.orientation, wanted);
    const double angle = way.norm();
    const double most = limits_.turning * elapsed;
    here_.orientation = angle > most ? here_.orientation.slerp(most / angle, wanted).normalized()
                                     : wanted.normalized();
  }

  MotionLimits limits_;
  double cruise_;  // [m/s] leaves room for the speed that the acceleration adds while it ends
  Pose here_;
  Vec3 velocity_ = Vec3::Zero(), acceleration_ = Vec3::Zero();
};

}  // namespace feltwire
