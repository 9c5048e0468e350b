#pragma once

#include <string>

#include "client/device/device.hpp"

namespace feltwire {

/// Asks the device until it is ready for force (Device::prepare()), and gives each new text of what
/// a person must do to `tell`. `waits(text)` waits between two questions; false: it asks no more.
/// Returns whether the device is ready.
template <class Tell, class Waits>
bool await_prepared(Device& device, Tell tell, Waits waits) {
  std::string told;
  while (true) {
    const std::string wanted(device.prepare());
    if (wanted.empty()) return true;
    if (wanted != told) tell(wanted);
    told = wanted;
    if (!waits(wanted)) return false;
  }
}

}  // namespace feltwire
