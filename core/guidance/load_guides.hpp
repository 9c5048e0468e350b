#pragma once
// The guides of a scene file.

#include <vector>

#include "core/guidance/guide.hpp"
#include "core/scene/json_document.hpp"

namespace feltwire {

namespace scene_file {
struct Scene;
}

/// Throws FileError.
std::vector<Guide> read_guides(const JsonDocument& document, const scene_file::Scene& scene);

}  // namespace feltwire
