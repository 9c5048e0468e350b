#pragma once
// The devices of 3D Systems (Touch, Touch X, Premium), through OpenHaptics' HD API (libHD), which
// is loaded where it is installed. Its own thread sets the pace: it calls back a thousand times a
// second.

#include "client/devices/drivers.hpp"

namespace feltwire {

/// The device of that name, as the maker's setup program calls it (request.name); empty: the
/// default one. Throws std::runtime_error that says what was looked for, or what the device needs.
OpenedDevice open_haptics(const DeviceRequest& request);

/// The maker's library; only a device has its version. Throws the same.
std::string open_haptics_library();

}  // namespace feltwire
