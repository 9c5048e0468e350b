#pragma once
// The devices of Force Dimension (omega, delta, sigma, lambda) and Novint's Falcon, through the
// maker's library (libdrd or libdhd, SDK 3), which is loaded where it is installed.

#include "client/devices/drivers.hpp"

namespace feltwire {

/// The device of that number (request.name: "", "0", "1"...). Throws std::runtime_error that says
/// what was looked for and where, or what the device needs.
OpenedDevice open_force_dimension(const DeviceRequest& request);

/// The maker's library and its version. Throws the same.
std::string force_dimension_library();

}  // namespace feltwire
