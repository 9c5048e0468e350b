#pragma once
// Objects so far from the origin that no hand comes there.

#include <optional>
#include <string>

#include "core/scene/scene.hpp"

namespace feltwire {

/// A warning where a bounded object lies beyond kMaxPosition, the farthest place of a hand: nobody
/// can touch it. It names the farthest objects and the remedy. Nothing where all are within reach.
std::optional<std::string> warning_of_unreachable_objects(const Scene& scene);

}  // namespace feltwire
