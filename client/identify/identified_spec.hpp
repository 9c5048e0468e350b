#pragma once
// A device's specification with its measured numbers, and its file.

#include <string>

#include "client/identify/estimate.hpp"
#include "core/device/device_file.hpp"

namespace feltwire {

/// Returns the specification that a device reported, with the sources of `requested`, or of the
/// built-in device that it names. Where they tell no lag or no transmission, that of the report is
/// the driver's assumption, and its source says so.
SourcedSpec reported_spec(SourcedSpec requested, const DeviceSpec& reported);

/// [s] The part of a measured lag that the device's late ticks are.
double late_time(const DeviceSpec& spec, const DeviceEstimate& found);

/// Returns `known` with the measured numbers: lower bounds for the numbers that the account uses.
/// The sources say so, with the estimate and `date`. The lag is written if the readings tell it; if
/// `known` has late ticks, it is the rest beyond late_time(). The transmission is written if the
/// readings tell it. Throws DeviceSpecError if the two contradict each other.
SourcedSpec identified_spec(SourcedSpec known, const DeviceEstimate& found,
                            const std::string& date);

/// The text of a file for --spec (docs/devices.md): all numbers, and all sources.
std::string device_file_text(const SourcedSpec& described);

}  // namespace feltwire
