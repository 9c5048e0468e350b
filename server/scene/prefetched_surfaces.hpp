#pragma once
// The version of the objects that clients have fetched from a scene.

#include <cstdint>
#include <string>

#include "core/scene/scene.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// The version of what clients with this tool have in full of the scene of `version` after so many
/// live `changes`.
std::uint32_t prefetched_version(const ToolView& view, std::uint32_t version,
                                 std::uint32_t changes);
/// The scene was loaded again since, or what a client has of it in full was changed. `parts`: what
/// the client lists again, "surfaces".
control::Refused other_version(std::uint32_t version, const std::string& parts);

}  // namespace feltwire
