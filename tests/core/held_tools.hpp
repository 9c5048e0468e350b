#pragma once
// Tools of hands, and the objects that they touch, for tests.

#include "core/base/numeric.hpp"
#include "core/contact/contact.hpp"
#include "tests/core/support.hpp"

namespace feltwire::test {

inline constexpr double kBall = 0.004;  // [m]
inline const Material kRough{
    .stiffness = 1000.0, .damping = 1.0, .static_friction = 0.5, .dynamic_friction = 0.4};

inline Object placed(Object object, const char* name, const Vec3& at) {
  object.name = name;
  object.pose.position = at;
  object.pose.orientation = Quaternion(Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()));
  return object;
}

/// A hand that wanders about the origin, drawn to a distance of at most `in`.
class Wanderer {
 public:
  Wanderer(std::uint64_t seed, double from, double in)
      : random_(seed), position_(from * random_.direction()), in_(in) {}
  Tool step() {
    const Vec3 out = direction(position_);
    velocity_ =
        0.9 * velocity_ + 3e-4 * random_.direction() - 0.02 * (length(position_) - in_) * out;
    position_ += velocity_;
    return {position_, velocity_ / 1e-3};
  }

 private:
  Random random_;
  Vec3 position_, velocity_ = Vec3::Zero();
  double in_;
};

}  // namespace feltwire::test
