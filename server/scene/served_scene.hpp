#pragma once

#include <cstdint>

#include "core/scene/scene.hpp"

namespace feltwire {

/// The scene that the sessions are in at present.
struct ServedScene {
  const Scene* scene;              // never null
  std::uint32_t version = 1;       // counts the scenes: one more with each reload
  std::uint32_t live_changes = 0;  // of materials and gravity so far
};

}  // namespace feltwire
