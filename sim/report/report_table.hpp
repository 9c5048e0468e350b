#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// Client reports (docs/devices.md) side by side, one column a client, for a reader who has never
/// seen one. Throws std::runtime_error naming the file and what is missing.
std::string report_table(const std::vector<std::filesystem::path>& reports);

}  // namespace feltwire
