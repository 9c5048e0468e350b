#pragma once
// The parts of a report about the device, and what is known of it beforehand.

#include <optional>
#include <string>

#include "client/hands/true_energy.hpp"
#include "client/run/json_values.hpp"
#include "client/run/rehearsal.hpp"
#include "core/device/device_spec.hpp"
#include "core/safety/safety.hpp"

namespace feltwire::report {

/// `kind`: as given to --device.
Json device(const std::string& kind, const DeviceSpec& spec);
Json safety(const SafetyLimits& limits);
/// The stiffness that the encoder allows, beside that of the scene [N/m]; 0: not known.
Json encoder(const DeviceSpec& spec, double scene_stiffness);
/// Null for a real device.
Json true_energy(const std::optional<TrueEnergy>& energy);
/// Null if there was none.
Json rehearsal(const std::optional<Rehearsal>& rehearsal);

}  // namespace feltwire::report
