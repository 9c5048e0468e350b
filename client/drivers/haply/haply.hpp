#pragma once
// Haply's Inverse3, Inverse3x and Minverse through the maker's service: --device haply[:ID[@PORT]].

#include <cstdint>
#include <string>

#include "client/drivers/common/driver.hpp"

namespace feltwire {

/// Opens the device `request.name`: "ID", "ID@PORT" or "@PORT". Without an id it takes the first
/// device, without a port 10001. The service answers each command, and this sets the servo's pace.
/// Throws std::runtime_error that names the error and the remedy.
OpenedDevice open_haply(const DeviceRequest& request);

/// Returns a description of the service at that port of this machine, as "service at port 10001,
/// first device 049D of 2". It sends nothing. Throws the same.
std::string haply_service(std::uint16_t port);
/// Returns that description for the usual port, 10001.
std::string haply_usual_service();

}  // namespace feltwire
