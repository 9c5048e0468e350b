#pragma once
// Messages to the user about a device that is slow, jumps or fails.

#include <string>

#include "client/servo/servo.hpp"
#include "client/servo/timed_device.hpp"

namespace feltwire {

/// "the device's read() takes 20.0 ms of a tick of 1.0 ms, ...", with the remedy; empty if its
/// calls take less than half a servo period [s] in 99 of 100 ticks. `paced`: the device sets the
/// pace.
std::string slow_device(const DeviceTimes& times, double period, bool paced);

/// ", 3 device faults (1 jump of the position)"; empty if there was none.
std::string device_faults_text(std::uint64_t faults, std::uint64_t jumps);

/// "the device gives no position since 1.50 s: ...", with the remedy; empty if there is no trouble.
/// `end` [s]: the time of the last tick.
std::string trouble_text(const std::optional<Servo::DeviceTrouble>& trouble, double end);

}  // namespace feltwire
