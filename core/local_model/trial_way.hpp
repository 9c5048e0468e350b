#pragma once
// A movement of a tool on which contact is tried before a servo uses it.

#include <cstdint>

#include "core/base/types.hpp"

namespace feltwire {

/// The tool comes from the free side, goes into an object, and then along it. [m, world]
struct TrialWay {
  std::uint16_t object = 0;  // its number in the scene
  Vec3 from = Vec3::Zero(), into = Vec3::Zero(), along = Vec3::Zero();
};

}  // namespace feltwire
