#pragma once

#include "core/bounding/step.hpp"

namespace feltwire {

/// mode `none`: F_d = F_e. The baseline that oscillates; known weakness: nothing is passive.
struct NoBound {
  Command step(const BoundingStep& s) noexcept { return s.command; }
  void set_held(const Command&) noexcept {}
};

}  // namespace feltwire
