#pragma once
// The guides of a scene file.

#include <vector>

#include "core/base/json_document.hpp"
#include "core/guidance/guide.hpp"

namespace feltwire {

namespace scene_file {
struct Scene;
}

/// Reads all guides of the file. Throws FileError that names the file, the line and the field.
std::vector<Guide> read_guides(const JsonDocument& document, const scene_file::Scene& scene);

}  // namespace feltwire
