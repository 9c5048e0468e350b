#pragma once
// The driver of Novint's Falcon over USB, without a maker's library.

#include "client/drivers/common/driver.hpp"

namespace feltwire {

/// A Falcon by its number, from 0, with the firmware file of the request where the device has none.
/// Throws std::runtime_error with what is wrong and the remedy.
OpenedDevice open_falcon(const DeviceRequest& request);
/// "FILE", of libusb.
std::string falcon_library();

}  // namespace feltwire
