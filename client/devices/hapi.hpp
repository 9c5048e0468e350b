#pragma once
// Haply's open 2-dof board (hAPI) at a serial port: --device hapi:PORT.

#include "client/devices/drivers.hpp"

namespace feltwire {

/// `request.name` is the port, /dev/ttyACM0. The board answers each torque with the angles that it
/// had then, which sets the servo's pace. Throws std::runtime_error that says what is wrong and the
/// remedy.
OpenedDevice open_hapi(const DeviceRequest& request);

}  // namespace feltwire
