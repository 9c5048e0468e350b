// The rules for a body.

#include <cmath>

#include "core/base/numeric.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene/validation.hpp"

namespace feltwire {
namespace {

constexpr double kLeastMass = 1e-6, kLargestMass = 1e6;        // [kg]
constexpr double kLeastDensity = 1e-3, kLargestDensity = 1e6;  // [kg/m^3]
constexpr double kLargestGravity = 1e3;                        // [m/s^2]

MaybeViolation within(const char* field, double value, double least, double most,
                      const char* unit) {
  if (value >= least && value <= most) return std::nullopt;
  return Violation{field, "must lie from " + number_text(least) + " to " + number_text(most) +
                              unit + ", is " + number_text(value) + "; check the unit"};
}

MaybeViolation broken_range(const Body& b) {
  if (std::isnan(b.low) || std::isnan(b.high) || !(b.low < b.high))
    return Violation{"range", "must be [low, high] with low below high, is [" + number_text(b.low) +
                                  ", " + number_text(b.high) + "]; swap or widen it"};
  if (b.low > 0.0 || b.high < 0.0)
    return Violation{"range", "must hold 0, where the body begins, is [" + number_text(b.low) +
                                  ", " + number_text(b.high) + "]; move the body's position"};
  return std::nullopt;
}

MaybeViolation jointless(const Body& b) {
  const Body none;
  const char* field = b.low != none.low || b.high != none.high ? "range"
                      : b.stiffness != 0.0                     ? "stiffness"
                      : b.rest != 0.0                          ? "rest"
                      : b.damping != 0.0                       ? "damping"
                      : b.friction != 0.0                      ? "friction"
                                                               : nullptr;
  if (field == nullptr) return std::nullopt;
  return Violation{field,
                   "is of a hinge or a slide, this body is free; name its joint or remove it"};
}

}  // namespace

MaybeViolation check(const MechanismOptions& o) {
  return first({within("gravity.x", o.gravity.x(), -kLargestGravity, kLargestGravity, " [m/s^2]"),
                within("gravity.y", o.gravity.y(), -kLargestGravity, kLargestGravity, " [m/s^2]"),
                within("gravity.z", o.gravity.z(), -kLargestGravity, kLargestGravity, " [m/s^2]"),
                within("tick", o.tick, kLeastTick, kLargestTick, " [s]")});
}

MaybeViolation check(const Body& b) {
  if (auto violation = first({broken_name(b.name), check(b.pose)})) return violation;
  if (b.mass.has_value() == b.density.has_value())
    return Violation{"mass", b.mass ? "stands beside a density; keep one of the two"
                                    : "is missing; give mass [kg] or density [kg/m^3]"};
  if (auto violation =
          b.mass ? within("mass", *b.mass, kLeastMass, kLargestMass, " [kg]")
                 : within("density", *b.density, kLeastDensity, kLargestDensity, " [kg/m^3]"))
    return violation;
  if (b.joint == Joint::free) return jointless(b);
  if (!b.axis.allFinite() || !(length(b.axis) > 0.0))
    return Violation{"axis", "has no direction: all of [x, y, z] are zero; give an axis"};
  return first({broken_range(b), within("stiffness", b.stiffness, 0.0, kMaxStiffness, ""),
                within("rest", b.rest, -kLargestTravel, kLargestTravel, ""),
                within("damping", b.damping, 0.0, kMaxDamping, ""),
                within("friction", b.friction, 0.0, kMaxDamping, "")});
}

}  // namespace feltwire
