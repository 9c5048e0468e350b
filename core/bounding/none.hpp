#pragma once

#include "core/bounding/step.hpp"

namespace feltwire {

/// mode `none`: F_d = F_e. The baseline that oscillates. Known weakness: nothing is passive.
template <class Real>
struct NoBound {
  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept { return s.command; }
  void set_held(const BasicCommand<Real>&) noexcept {}
};

}  // namespace feltwire
