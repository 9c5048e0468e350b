#pragma once
// Small files and folders of /sys and /proc, and the udev rules that follow from them.

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// Returns the first line of a small file. Empty if there is none.
std::string line_of(const std::filesystem::path& file);

/// Returns the entries of a folder, sorted by name. Empty if it cannot be read.
std::vector<std::filesystem::path> entries(const std::filesystem::path& folder);

/// Returns the sentence that tells the user how to install a udev rule.
std::string rule_to_paste(const std::string& rule);

}  // namespace feltwire
