#pragma once
// A plant from a file.

#include <filesystem>
#include <string>
#include <string_view>

#include "client/hands/plant.hpp"

namespace feltwire {

/// Reads a plant (JSON against client/hands/plant.fbs). Throws FileError that names the file, the
/// line, the field and the remedy.
Plant load_plant(const std::filesystem::path& file);

/// The file in "plant=FILE", the name of a simulated device (--device simulated:plant=FILE). Throws
/// std::invalid_argument if the name is another.
std::string plant_file_of(std::string_view name);

}  // namespace feltwire
