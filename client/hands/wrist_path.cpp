#include "client/hands/wrist_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/base/enum_names.hpp"
#include "core/base/numeric.hpp"

namespace feltwire {

WristPath wrist_path(std::string_view given) {
  return enum_from_name<WristPath>("wrist", given, kWristPathNames);
}

IntendedTurn::IntendedTurn(const WristTask& wrist, const HandTask& hand)
    : wrist_(wrist),
      frequency_(hand.frequency),
      lead_in_(hand.lead_in),
      air_(hand.air),
      normal_(direction(hand.normal)),
      along_(direction(Vec3(hand.along - hand.along.dot(normal_) * normal_))),
      across_(normal_.cross(along_)) {
  if (!(std::abs(wrist.angle) < std::numbers::pi))
    throw std::invalid_argument("the wrist's angle must be less than pi [rad], is " +
                                std::to_string(wrist.angle));
  const IntendedMotion checked(hand);
}

Vec3 IntendedTurn::rotation(double t) const noexcept {
  const double since = std::max(0.0, t - air_);
  const double a = 2.0 * std::numbers::pi * frequency_ * since;
  const double angle = wrist_.angle * smoothstep(since / lead_in_);
  switch (wrist_.path) {
    case WristPath::still:
      break;
    case WristPath::screwdriver:
      return angle * std::sin(a) * normal_;
    case WristPath::tilt:
      return angle * (std::cos(a) * along_ + std::sin(a) * across_);
    case WristPath::scrape:
      return angle * std::cos(a) * across_;
    case WristPath::roll:
      return angle * std::sin(a) * across_;
  }
  return Vec3::Zero();
}

}  // namespace feltwire
