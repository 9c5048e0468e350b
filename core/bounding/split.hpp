#pragma once

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// Splits a force: the part along the command's elastic direction `elastic` is elastic, the rest is
/// frictional. For modes that bound the whole force and must still report its parts.
template <class Real>
inline BasicCommand<Real> split_along(const Vector3<Real>& force,
                                      const Vector3<Real>& elastic) noexcept {
  BasicCommand<Real> parts;
  parts.elastic = along(force, direction(elastic));
  parts.frictional = force - parts.elastic;
  return parts;
}

}  // namespace feltwire
