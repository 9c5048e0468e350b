#pragma once
// The entries of feltwire's own bounding methods, for the registry (core/bounding/method.hpp) and
// for studies that use another arithmetic. Each method has a file in this folder.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "core/base/enum_names.hpp"
#include "core/bounding/contact_frame.hpp"
#include "core/bounding/credited.hpp"
#include "core/bounding/energy_tank.hpp"
#include "core/bounding/limits.hpp"
#include "core/bounding/method.hpp"
#include "core/bounding/midpoint.hpp"
#include "core/bounding/none.hpp"
#include "core/bounding/passivity_control.hpp"
#include "core/bounding/per_axis.hpp"
#include "core/bounding/per_axis_projected.hpp"
#include "core/bounding/total_energy.hpp"
#include "core/bounding/virtual_coupling.hpp"

namespace feltwire {
namespace built_in {

template <class Real>
PerAxisBound<Real> axes(const BoundingConfig& c) {
  const auto port = [&](const Damping& damping, std::optional<double> c1,
                        std::optional<double> c2) {
    const Vec3 b = damping.per_axis();
    EbaAxes<Real> axes;
    for (int i = 0; i < 3; ++i) {
      const double first = c1.value_or(b[i] / c.reckoned_period());
      axes.axis[static_cast<std::size_t>(i)] = {static_cast<Real>(first),
                                                static_cast<Real>(c2.value_or(first))};
    }
    return axes;
  };
  return {.translation = port(c.damping, c.c1, c.c2),
          .rotation = port(c.rotational_damping, c.c1_rotation, c.c2_rotation),
          .torque = c.rotation};
}

/// Throws std::invalid_argument for a coupling that is not passive.
template <class Real>
Coupling<Real> coupling(const CouplingConfig& c, double b, double period,
                        const std::string& suffix) {
  const auto require = [](bool good, const std::string& message) {
    if (!good) throw std::invalid_argument(message);
  };
  const auto number = [](double value) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%g", value);
    return std::string(text.data());
  };
  const double stiffness =
      c.stiffness.value_or(std::max(0.0, 2.0 * (b - c.damping.value_or(0.0)) / period));
  require(stiffness >= 0.0 && stiffness <= kLargestStiffness,
          "coupling stiffness" + suffix + " must be finite and not negative");
  const double damping = c.damping.value_or(std::max(0.0, b - 0.5 * stiffness * period));
  require(damping >= 0.0 && std::isfinite(damping),
          "coupling damping" + suffix + " must be finite and not negative");
  require(c.mass > 0.0 && std::isfinite(c.mass),
          "the tool's mass" + suffix + " must be finite and above zero");
  // Colgate's condition, with room for the rounding of its own default.
  const double needed = 0.5 * stiffness * period + damping;
  require(needed <= b * (1.0 + 1e-12),
          "the virtual coupling" + suffix + " is not passive: k T / 2 + b_c = " + number(needed) +
              " is above the device's damping " + number(b) +
              "; lower its stiffness or its damping, or raise the servo rate");
  return {static_cast<Real>(stiffness), static_cast<Real>(damping), static_cast<Real>(c.mass)};
}

template <class Real>
PassivityPort<Real> port(const BoundingConfig& c, const Damping& damping, double max) {
  return {c.reference, static_cast<Real>(max),
          static_cast<Real>(damping.least() / c.reckoned_period())};
}

template <class Real>
Credited<Real> credited(const BoundingConfig& c) {
  constexpr double kArmSquared = 0.04 * 0.04;  // [m^2] squared lever at which a wrist turns a tool
  return {{.damping = c.damping.least(), .credit = c.hand_damping, .stiffness = c.stiffness},
          {.damping = c.rotational_damping.least(), .credit = kArmSquared * c.hand_damping},
          c.period,
          c.quantum,
          c.rotation,
          c.lag};
}

/// A passivity controller of either kind.
template <class Real, template <class> class Controller>
BasicBoundingLaw<Real> controller(const BoundingConfig& c) {
  return Controller<Real>(port<Real>(c, c.damping, c.max_force),
                          port<Real>(c, c.rotational_damping, c.max_torque), c.rotation);
}

}  // namespace built_in

/// The paper's methods, then contact_frame and the shaping methods, then those of research.
template <class Real>
std::array<BasicBoundingMethod<Real>, 13> built_in_methods() {
  using namespace built_in;
  using Law = BasicBoundingLaw<Real>;
  using Config = const BoundingConfig&;
  constexpr Faults kOverlongHolds{.overlong_holds = true};
  constexpr Faults kLimitsAndUnknown{.reductions = true, .unknown_inputs = true};
  return {{
      {.name = "none",
       .summary = "what the scene commands, as it is: the baseline, which oscillates",
       .make = [](Config) -> Law { return NoBound<Real>{}; },
       .research = false,
       .admits_reduction = true},
      {.name = "total_energy",
       .summary = "the paper's Eq. 1: one sum of energy over all axes",
       .make = [](Config c) -> Law { return TotalEnergyBound<Real>{.axes = axes<Real>(c)}; },
       .research = false},
      {.name = "per_axis",
       .summary = "the paper's Eq. 2: every axis by itself; the direction of the force bends",
       .make = [](Config c) -> Law { return axes<Real>(c); },
       .research = false,
       .promise = Promise::port_by_axis,
       .kept_despite = kLimitsAndUnknown},
      {.name = "per_axis_projected",
       .summary = "the paper's Eq. 3: the same, then along the commanded direction",
       .make = [](Config c) -> Law { return ProjectedBound<Real>{axes<Real>(c)}; },
       .research = false},
      {.name = kDefaultMethod,
       .summary = "passive by itself, for every hand, and true to the direction",
       .make = [](Config c) -> Law {
         return ContactFrameBound<Real>(Metric<Real>(c.damping), Metric<Real>(c.rotational_damping),
                                        static_cast<Real>(c.reckoned_period()), c.projection,
                                        c.storage, c.rotation);
       },
       .research = false,
       .projects = true,
       .promise = Promise::port,
       .kept_despite = kAllFaults,
       .admits_reduction = true,
       .needs_every_axis_damped = true},
      {.name = kSessionMethod,
       .summary = "calm by its shaping, passive by the account behind it; a session's default",
       .make = [](Config c) -> Law {
         return Shaped<Real>(credited<Real>(c), c.quantum, c.period, c.lag);
       },
       .research = false,
       .admits_reduction = true,
       .moves_probe = true,
       .shapes = true},
      {.name = "midpoint",
       .summary = "asks the client's surfaces half a sample ahead; an account behind it",
       .make = [](Config c) -> Law { return Midpoint<Real>(c.quantum, c.period, c.lag); },
       .admits_reduction = true,
       .moves_probe = true,
       .shapes = true},
      {.name = "credited",
       .summary = "contact_frame with the damping of a hand; an account behind it",
       .make = [](Config c) -> Law { return credited<Real>(c); },
       .admits_reduction = true,
       .shapes = true},
      {.name = "virtual_coupling",
       .summary = "a spring and a damper to a simulated tool",
       .make = [](Config c) -> Law {
         return VirtualCoupling<Real>(
             coupling<Real>(c.coupling, c.damping.least(), c.reckoned_period(), ""),
             coupling<Real>(c.coupling_rotation, c.rotational_damping.least(), c.reckoned_period(),
                            " (rotation)"),
             c.rotation);
       },
       .promise = Promise::coupling,
       .moves_probe = true},
      {.name = "passivity_control",
       .summary = "passivity observer and controller in series, by axis",
       .make = controller<Real, PassivityControl>,
       .promise = Promise::own_sum_by_axis,
       .kept_despite = kOverlongHolds,
       .keeps_all = true},
      {.name = "passivity_control_parallel",
       .summary = "the same in parallel: it moves the point that touches the scene",
       .make = controller<Real, PassivityControlParallel>,
       .moves_probe = true},
      {.name = "passivity_control_directional",
       .summary = "the same with one observer, along force and torque",
       .make = controller<Real, PassivityControlDirectional>,
       .promise = Promise::own_sum,
       .kept_despite = kOverlongHolds,
       .keeps_all = true},
      {.name = "energy_tank",
       .summary = "the least conservative bound: a tank of energy for each channel",
       .make = [](Config c) -> Law {
         return EnergyTankBound<Real>(Metric<Real>(c.damping), Metric<Real>(c.rotational_damping),
                                      static_cast<Real>(c.reckoned_period()), c.rotation);
       },
       .promise = Promise::port,
       .kept_despite = kAllFaults,
       .keeps_all = true,
       .admits_reduction = true,
       .needs_every_axis_damped = true},
  }};
}

}  // namespace feltwire
