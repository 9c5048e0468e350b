#pragma once
// A device's specification from a file.

#include <filesystem>
#include <string_view>

#include "core/device/device_spec.hpp"

namespace feltwire {

/// Reads a specification (JSON against core/device/device_spec.fbs). Throws FileError naming the
/// file, the line, the field and the remedy.
DeviceSpec load_device_spec(const std::filesystem::path& file);

/// Finds a device as a command line names it: a built-in one by its name, or a file by a path that
/// ends in .json. Throws std::invalid_argument listing the built-in names, or FileError.
DeviceSpec device_spec(std::string_view name_or_file);

}  // namespace feltwire
