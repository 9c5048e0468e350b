#pragma once
// A device behind a plugin (client/drivers/plugin/feltwire_device_v1.h).

#include "client/drivers/common/driver.hpp"

namespace feltwire {

/// Opens "FILE.so" or "FILE.so:ARGUMENTS". Throws std::runtime_error that names the file, the error
/// and the remedy.
OpenedDevice open_plugin(const DeviceRequest& request);

}  // namespace feltwire
