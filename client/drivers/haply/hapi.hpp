#pragma once
// Haply's open 2-dof board (hAPI) at a serial port: --device hapi:PORT.

#include "client/drivers/common/driver.hpp"

namespace feltwire {

/// Opens the board at the port `request.name` (/dev/ttyACM0). The board answers each torque with
/// the angles at that moment, and this sets the servo's pace. Throws std::runtime_error that names
/// the error and the remedy.
OpenedDevice open_hapi(const DeviceRequest& request);

}  // namespace feltwire
