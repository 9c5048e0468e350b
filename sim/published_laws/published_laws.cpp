#include "sim/published_laws/published_laws.hpp"

#include <algorithm>
#include <array>

#include "sim/published_laws/force_augmentation.hpp"
#include "sim/published_laws/position_memory.hpp"
#include "sim/published_laws/time_domain_passivity.hpp"
#include "sim/published_laws/two_layer_tank.hpp"

namespace feltwire {
namespace {

using Config = const BoundingConfig&;

constexpr double kAllowance = 5e-3;  // [J] allowance of bounded_output, as TwoLayerTank::kLevel

const std::array kLaws = {
    BoundingMethod{
        .name = "tdpc_exact",
        .summary = "time-domain passivity control, exact pairing (Ryu et al. 2004)",
        .make = [](Config c) -> BoundingLaw { return TimeDomainPassivity(c.max_force); }},
    BoundingMethod{.name = "bounded_output",
                   .summary = "the same with an allowance, in place of ISS (Jafari & Ryu 2015)",
                   .make = [](Config c) -> BoundingLaw {
                     return TimeDomainPassivity(c.max_force, kAllowance);
                   }},
    BoundingMethod{.name = "force_augmentation",
                   .summary = "successive force augmentation (Singh, Jafari & Ryu 2019)",
                   .make = [](Config c) -> BoundingLaw {
                     return ForceAugmentation(2.0 * c.damping.least() / c.period);
                   }},
    BoundingMethod{.name = "force_augmentation_transient",
                   .summary = "the same, after a landing on the surface's own stiffness",
                   .make = [](Config c) -> BoundingLaw {
                     return ForceAugmentation(2.0 * c.damping.least() / c.period, true);
                   }},
    BoundingMethod{.name = "position_memory",
                   .summary = "memory-based passivation (Ryu & Yoon 2014)",
                   .make = [](Config c) -> BoundingLaw { return PositionMemory(c.quantum); }},
    BoundingMethod{
        .name = "two_layer_tank",
        .summary = "the passivity layer of the two-layer approach (Franken et al. 2011)",
        .make = [](Config c) -> BoundingLaw { return TwoLayerTank(c.damping.least(), c.period); }},
};

}  // namespace

std::span<const BoundingMethod> published_laws() { return kLaws; }

const BoundingMethod& law(std::string_view name) {
  const auto found = std::find_if(kLaws.begin(), kLaws.end(),
                                  [&](const BoundingMethod& m) { return m.name == name; });
  return found != kLaws.end() ? *found : bounding_method(name);
}

}  // namespace feltwire
