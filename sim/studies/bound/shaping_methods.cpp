#include "sim/studies/bound/shaping_methods.hpp"

#include "core/bounding/credited.hpp"
#include "core/bounding/method.hpp"
#include "core/bounding/midpoint.hpp"

namespace feltwire {
namespace {

constexpr double kCredit = 1.2;              // a [N s/m]: what a hand on a device usually has
constexpr double kArmSquared = 0.04 * 0.04;  // [m^2] of the arm at which a wrist turns a tool

Credited<double> credited(const BoundingConfig& c) {
  return {{.damping = c.damping.least(), .credit = kCredit},
          {.damping = c.rotational_damping.least(), .credit = kArmSquared * kCredit},
          c.period,
          c.quantum,
          c.rotation};
}

bool add_all() {
  add_bounding_method(
      {.name = "midpoint",
       .summary = "asks the scene half a sample ahead; needs an account behind it",
       .make = [](const BoundingConfig&) -> BoundingLaw { return Midpoint<double>{}; },
       .admits_reduction = true,
       .moves_probe = true});
  add_bounding_method({.name = "credited",
                       .summary = "contact_frame with a hand's damping; needs an account behind it",
                       .make = [](const BoundingConfig& c) -> BoundingLaw { return credited(c); },
                       .admits_reduction = true});
  add_bounding_method(
      {.name = "shaped",
       .summary = "midpoint for commands made at the device, credited for late ones",
       .make = [](const BoundingConfig& c) -> BoundingLaw { return Shaped<double>(credited(c)); },
       .admits_reduction = true,
       .moves_probe = true});
  return true;
}

}  // namespace

void add_shaping_methods() { [[maybe_unused]] static const bool kOnce = add_all(); }

}  // namespace feltwire
