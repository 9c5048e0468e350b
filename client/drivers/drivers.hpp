#pragma once
// The kinds of device for --device.

#include <span>
#include <string>
#include <string_view>

#include "client/drivers/common/driver.hpp"

namespace feltwire {

std::span<const Driver> drivers();

/// "KIND or KIND:NAME" of all drivers, each with its summary, for --help.
std::string driver_choices();

/// A driver and the name after its kind on the command line.
struct DriverChoice {
  const Driver* driver = nullptr;
  std::string name;
};

/// Parses "KIND" or "KIND:NAME". Throws std::invalid_argument that lists the existing kinds, or
/// says that a name is missing or does not fit the kind.
DriverChoice chosen_driver(std::string_view words);

/// Returns the file of the firmware. Throws std::invalid_argument if there is one and the driver
/// takes none.
std::string firmware_for(const Driver& driver, const std::string& file);

}  // namespace feltwire
