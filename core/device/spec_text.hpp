#pragma once
// The text of a specification for people: its numbers and their sources.

#include <string>
#include <vector>

#include "core/device/device_file.hpp"

namespace feltwire {

/// A line for each number: field, value, unit, source. It leaves out numbers that the device does
/// not have (torque of a device without rotation) and that have no source.
std::string spec_table(const SourcedSpec& described);

/// A sentence for each number that the account, or what is said of a first press, relies on and
/// that is an assumption: "damping 0.05 N s/m is an assumption; measure yours with feltwire-client
/// identify". A source "assumption for USB" is named in it, with the field of a device file as the
/// remedy. One more if the encoder is not at the motor, where no bound holds. Empty: there is none.
std::vector<std::string> assumptions(const SourcedSpec& described);

}  // namespace feltwire
