#include "sim/measure/methods.hpp"

#include <array>

#include "core/base/enum_names.hpp"

namespace feltwire {
namespace {

using Config = BoundingConfig;

template <Storage kStorage>
void contact_frame(Config& config) {
  config.mode = "contact_frame";
  config.projection = Projection::cone;  // the default of sessions (docs/bounding.md)
  config.storage = kStorage;
}

template <PassivityReference kReference>
void passivity_control(Config& config) {
  config.mode = "passivity_control";
  config.reference = kReference;
}

constexpr std::array kMethods = {
    Method{"none"},
    Method{"total_energy"},
    Method{"per_axis"},
    Method{"per_axis_projected"},
    Method{"contact_frame", contact_frame<Storage::minimal>},
    Method{"contact_frame_elastic", contact_frame<Storage::elastic>},
    Method{"virtual_coupling"},
    Method{"passivity_control", passivity_control<PassivityReference::zero>},
    Method{"passivity_control_following", passivity_control<PassivityReference::following>},
    Method{"passivity_control_parallel"},
    Method{"passivity_control_directional"},
    Method{"energy_tank"},
};

}  // namespace

std::span<const Method> methods() { return kMethods; }

const Method& method(std::string_view label) {
  return get_named("method", label, kMethods, &Method::label);
}

}  // namespace feltwire
