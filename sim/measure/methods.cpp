#include "sim/measure/methods.hpp"

#include <array>

#include "core/base/choice.hpp"

namespace feltwire {
namespace {

template <BoundingMode kMode>
void mode(BoundingConfig& config) {
  config.mode = kMode;
}

template <Storage kStorage>
void contact_frame(BoundingConfig& config) {
  config.mode = BoundingMode::contact_frame;
  config.projection = Projection::cone;  // as sessions use it (docs/bounding.md, "Measured")
  config.storage = kStorage;
}

template <PassivityReference kReference>
void passivity_control(BoundingConfig& config) {
  config.mode = BoundingMode::passivity_control;
  config.reference = kReference;
}

constexpr std::array kMethods = {
    Method{"none", mode<BoundingMode::none>},
    Method{"total_energy", mode<BoundingMode::total_energy>},
    Method{"per_axis", mode<BoundingMode::per_axis>},
    Method{"per_axis_projected", mode<BoundingMode::per_axis_projected>},
    Method{"contact_frame", contact_frame<Storage::minimal>},
    Method{"contact_frame_elastic", contact_frame<Storage::elastic>},
    Method{"virtual_coupling", mode<BoundingMode::virtual_coupling>},
    Method{"passivity_control", passivity_control<PassivityReference::zero>},
    Method{"passivity_control_following", passivity_control<PassivityReference::following>},
    Method{"passivity_control_parallel", mode<BoundingMode::passivity_control_parallel>},
    Method{"passivity_control_directional", mode<BoundingMode::passivity_control_directional>},
    Method{"energy_tank", mode<BoundingMode::energy_tank>},
};

}  // namespace

std::span<const Method> methods() { return kMethods; }

const Method& method(std::string_view label) {
  return chosen("method", label, kMethods, &Method::label);
}

}  // namespace feltwire
