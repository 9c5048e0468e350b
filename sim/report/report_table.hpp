#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// Client reports (docs/devices.md) side by side, one column for each client, for a reader who has
/// never seen one. Throws std::runtime_error that names the file and the missing part.
std::string report_table(const std::vector<std::filesystem::path>& reports);

}  // namespace feltwire
