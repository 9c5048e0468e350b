#pragma once
// A folder for one user alone.

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

namespace feltwire {

/// Creates the folder with mode 0700 from the first moment on, and the folders above it with the
/// usual mode. A folder that is there stays as it is. Returns what failed, with the system's code.
std::error_code make_private_folder(const std::filesystem::path& folder);

/// The fault of a folder that users other than its owner may read, search or write, with the
/// remedy; empty: nothing, or there is no such folder.
std::optional<std::string> shared_folder(const std::filesystem::path& folder);

}  // namespace feltwire
