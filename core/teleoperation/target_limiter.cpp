#include "core/teleoperation/target_limiter.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

void check(double value, const char* name, bool zero_is_allowed) {
  if (std::isfinite(value) && (value > 0.0 || (zero_is_allowed && value == 0.0))) return;
  throw std::invalid_argument(std::string("target limits: ") + name + " is " +
                              std::to_string(value) + "; give a finite number " +
                              (zero_is_allowed ? "of 0 or more" : "above 0"));
}

}  // namespace

TargetLimiter::TargetLimiter(const TargetLimits& limits) : limits_(limits) {
  check(limits.stiffness, "stiffness", false);
  check(limits.speed, "speed", false);
  check(limits.leash, "leash", false);
  check(limits.first_touch, "first_touch", true);
  check(limits.unfelt, "unfelt", true);
}

/// Counts the energy that the hand gives during this contact, minus the energy that the environment
/// receives.
void TargetLimiter::account(const Sample& s) noexcept {
  double paid = 0.0;
  if (std::isfinite(s.hand_work)) {
    const double more = s.hand_work - work_seen_;
    if (std::isfinite(more)) paid = more;
    work_seen_ = s.hand_work;
  }
  const Vec3 way = s.robot - robot_;
  robot_ = s.robot;
  if (s.surface == 0 || !touched_) {
    paid_ = 0.0;  // Drop the remaining energy of the previous contact.
  } else {
    // Only the part of a force above limits_.unfelt counts, for energy in both directions.
    const double given = s.force.allFinite() ? s.force.dot(way) : 0.0;
    const double free = limits_.unfelt * length(way);
    paid_ += paid + std::copysign(std::max(0.0, std::abs(given) - free), given);
    const double largest = limits_.leash * limits_.leash / (2.0 * limits_.stiffness);
    paid_ = std::clamp(paid_, 0.0, largest);
  }
  touched_ = s.surface != 0;
}

const Vec3& TargetLimiter::step(const Sample& s) noexcept {
  if (!s.robot.allFinite()) return target_;
  if (!begun_) {
    target_ = robot_ = s.robot;
    work_seen_ = std::isfinite(s.hand_work) ? s.hand_work : 0.0;
    begun_ = true;
  }
  const double k = limits_.stiffness;
  const Vec3 before = target_ - s.robot;  // offset e' of the previous target from the robot
  account(s);
  Vec3 way = s.wanted.allFinite() ? Vec3(s.wanted - target_) : Vec3::Zero();
  way *= std::min(1.0, limits_.speed * std::max(0.0, s.elapsed) / std::max(length(way), 1e-12));
  Vec3 after = before + way;  // offset e of the new target from the robot
  double most = limits_.leash / k;
  if (s.surface != 0) {
    if (s.known < s.surface) most = std::min(most, limits_.first_touch / k);
    const double felt = limits_.unfelt / k + std::sqrt(2.0 * paid_ / k);
    most = std::min(most, std::max(length(before), felt));
  }
  const double stretched = length(after);
  if (stretched > most) after *= most / stretched;
  target_ = s.robot + after;
  return target_;
}

}  // namespace feltwire
