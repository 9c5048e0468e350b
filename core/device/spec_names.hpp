#pragma once
// The names of the built-in specifications.

#include <string>
#include <vector>

namespace feltwire {

/// In a fixed order.
std::vector<std::string> device_spec_names();

}  // namespace feltwire
