#pragma once
// The devices of 3D Systems (Touch, Touch X, Premium), through OpenHaptics' HD API (libHD). The
// program loads the installed library. The library's own thread sets the pace: it calls back a
// thousand times a second.

#include "client/drivers/common/driver.hpp"

namespace feltwire {

/// Opens the device `request.name`, a name of the maker's setup program. Empty: the default device.
/// Throws std::runtime_error that names the missing library, or the fault of the device.
OpenedDevice open_haptics(const DeviceRequest& request);

/// Returns the file of the maker's library; only a device has its version. Throws the same.
std::string open_haptics_library();

}  // namespace feltwire
