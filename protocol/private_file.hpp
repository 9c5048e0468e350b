#pragma once
// Files with secrets in them.

#include <filesystem>
#include <optional>
#include <string>

namespace feltwire {

/// What is wrong with the mode of a file that only its owner should read, and the remedy, in one
/// line that names the file; nothing where it is good, or not there. A file of root's may be
/// readable by a group, as the system's own keys are.
std::optional<std::string> exposure(const std::filesystem::path& file);

/// The same for a folder that only its owner should write to: whoever else may can put other files
/// in the place of those there.
std::optional<std::string> open_folder(const std::filesystem::path& folder);

}  // namespace feltwire
