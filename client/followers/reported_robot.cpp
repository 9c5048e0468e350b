#include "client/followers/reported_robot.hpp"

#include <cmath>

namespace feltwire {
namespace {

bool is_finite(const FollowerTarget& target) {
  return target.pose.position.allFinite() && target.pose.orientation.coeffs().allFinite() &&
         std::isfinite(target.gripper);
}

}  // namespace

FollowerReading ReportedRobot::read(Nanoseconds now, bool connected) noexcept {
  fresh_ = connected && reported_ && now - reported_at_ <= kSilent;
  FollowerReading reading = state_;
  reading.ok = state_.ok && fresh_;
  return reading;
}

FollowerTarget ReportedRobot::write(const FollowerTarget& target, bool held) noexcept {
  if (!reported_) return target;
  const bool follows = fresh_ && state_.ok && !state_.stopped && !held;
  if (!follows)
    target_ = {state_.commanded, state_.gripper};
  else if (is_finite(target))
    target_ = target;
  return target_;
}

}  // namespace feltwire
