#pragma once
// Checks of files that contain secrets.

#include <filesystem>
#include <optional>
#include <string>

namespace feltwire {

/// Checks the mode of a file that only its owner should read. Returns one line that names the file,
/// the fault and the remedy; empty if the mode is good or there is no file. A file of root may be
/// readable by a group, as the system's own keys are.
std::optional<std::string> exposure(const std::filesystem::path& file);

/// Checks a folder in the same way. Only its owner should write to it: other writers could replace
/// its files.
std::optional<std::string> open_folder(const std::filesystem::path& folder);

}  // namespace feltwire
