#pragma once
// The devices of Force Dimension (omega, delta, sigma, lambda) and Novint's Falcon, through the
// maker's library (libdrd or libdhd, SDK 3), which is loaded where it is installed.

#include "client/drivers/common/driver.hpp"

namespace feltwire {

/// Opens the device with that number (request.name: "", "0", "1"...). Throws std::runtime_error
/// that names the missing library and the searched places, or the fault of the device.
OpenedDevice open_force_dimension(const DeviceRequest& request);

/// Returns the file of the maker's library and its version. Throws the same.
std::string force_dimension_library();

}  // namespace feltwire
