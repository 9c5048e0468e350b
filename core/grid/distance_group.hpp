#pragma once
// Internal to core/grid: eight queries of a distance grid at once.

#include "core/grid/brick_samples.hpp"
#include "core/grid/field_group.hpp"

namespace feltwire {

/// Distance and gradient at the eight places. False, without a result, if one of them is in no
/// brick with samples. Never allocates. Precondition: Real is float or double.
template <class Real>
bool evaluate_group(const BrickSamples<Real>& grid, FieldGroup& group) noexcept;

}  // namespace feltwire
