#pragma once
// Small files and folders of /sys and /proc, and the udev rules that follow from them.

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

/// The first line of a small file; empty where there is none.
std::string line_of(const std::filesystem::path& file);

/// The entries of a folder, by name; none where it cannot be read.
std::vector<std::filesystem::path> entries(const std::filesystem::path& folder);

/// What to do with a udev rule.
std::string rule_to_paste(const std::string& rule);

}  // namespace feltwire
