#pragma once
// Haply's Inverse3, Inverse3x and Minverse through the maker's service: --device haply[:ID], and
// behind an at sign the service's port.

#include <cstdint>
#include <string>

#include "client/devices/drivers.hpp"

namespace feltwire {

/// `request.name`: the device's id, or nothing for the first; behind an @ the service's port, else
/// 10001. The service answers each command, which sets the servo's pace. Throws std::runtime_error
/// that says what is wrong and the remedy.
OpenedDevice open_haply(const DeviceRequest& request);

/// "service at port 10001, first device 049D of 2": what the service at that port of
/// this machine says by itself; nothing is sent. Throws the same.
std::string haply_service(std::uint16_t port);
/// At the usual port.
std::string haply_usual_service();

}  // namespace feltwire
