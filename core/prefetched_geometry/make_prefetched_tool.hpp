#pragma once
// Makes a tool with a body and its solids ready from the data that travels.

#include <memory>
#include <vector>

#include "core/local_model/prefetched_tool.hpp"

namespace feltwire {

/// Throws std::invalid_argument if a number is not possible for a tool or a solid.
std::shared_ptr<const PrefetchedTool> make_prefetched_tool(std::uint32_t version,
                                                           const BodyData& tool,
                                                           const std::vector<SolidData>& solids);

}  // namespace feltwire
