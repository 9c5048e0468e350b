#pragma once
// Makes a tool with a body and its solids ready from the data that travels.

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "core/local_model/prefetched_tool.hpp"

namespace feltwire {

/// The grids of the meshes take at most `grid_room` [bytes] together. A mesh whose grid goes beyond
/// it is left out (PrefetchedTool::objects). Throws std::invalid_argument if a number is not
/// possible for a tool or a solid.
std::shared_ptr<const PrefetchedTool> make_prefetched_tool(
    std::uint32_t version, const BodyData& tool, const std::vector<SolidData>& solids,
    std::size_t grid_room = std::numeric_limits<std::size_t>::max());

}  // namespace feltwire
