#pragma once
// A bounding law in a shared library (sim/own_laws/feltwire_law_v1.h).

#include <filesystem>

namespace feltwire {

/// Loads the library and adds its law to the registry (add_own_law()). Throws std::runtime_error or
/// std::invalid_argument that names the file, the error and the remedy.
void add_library_law(const std::filesystem::path& file);

}  // namespace feltwire
