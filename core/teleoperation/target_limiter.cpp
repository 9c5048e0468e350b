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

const Vec3& TargetLimiter::step(const Sample& s) noexcept {
  if (!s.robot.allFinite()) return target_;
  if (!begun_) {
    target_ = s.robot;
    work_seen_ = std::isfinite(s.hand_work) ? s.hand_work : 0.0;
    begun_ = true;
  }
  if (std::isfinite(s.hand_work)) {
    paid_ = std::max(0.0, paid_ + s.hand_work - work_seen_);
    work_seen_ = s.hand_work;
  }
  const double k = limits_.stiffness;
  const Vec3 before = target_ - s.robot;  // e'
  Vec3 way = s.wanted.allFinite() ? Vec3(s.wanted - target_) : Vec3::Zero();
  way *= std::min(1.0, limits_.speed * std::max(0.0, s.elapsed) / std::max(length(way), 1e-12));
  Vec3 after = before + way;  // e
  double most = limits_.leash / k;
  if (s.surface != 0) {
    if (s.known != s.surface) most = std::min(most, limits_.first_touch / k);
    const double free = limits_.unfelt / k;
    const double stored = before.squaredNorm();
    most = std::min(most, std::max(free, std::sqrt(stored + 2.0 * paid_ / k)));
  }
  const double stretched = length(after);
  if (stretched > most) after *= most / stretched;
  if (s.surface != 0)
    paid_ = std::max(0.0, paid_ - 0.5 * k * (after.squaredNorm() - before.squaredNorm()));
  else if (touched_ || s.known == 0)
    paid_ = 0.0;  // the contact is left: what was not spent is gone
  touched_ = s.surface != 0;
  target_ = s.robot + after;
  return target_;
}

}  // namespace feltwire
