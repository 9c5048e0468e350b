#pragma once
// A device's specification with what was measured of it, and its file.

#include <string>

#include "client/identify/estimate.hpp"
#include "core/device/device_file.hpp"

namespace feltwire {

/// `known` with the measured numbers: the lower bounds where the account counts on them. The
/// sources say so, with the estimate and `date`. Throws DeviceSpecError where the two contradict
/// each other.
SourcedSpec identified_spec(SourcedSpec known, const DeviceEstimate& found,
                            const std::string& date);

/// The text of a file for --spec (docs/devices.md): all numbers, and all sources.
std::string device_file_text(const SourcedSpec& described);

}  // namespace feltwire
