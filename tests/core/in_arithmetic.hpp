#pragma once
// The bounding methods in any arithmetic.

#include "core/bounding/bounding_template.hpp"
#include "core/bounding/built_in_methods.hpp"
#include "core/bounding/contact_frame_template.hpp"

namespace feltwire::test {

template <class Real>
BasicBounding<Real> bounding_in(const BoundingConfig& config) {
  static const auto methods = built_in_methods<Real>();
  return {get_named("method", config.mode, methods, &BasicBoundingMethod<Real>::name), config};
}

}  // namespace feltwire::test
