#pragma once

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// Parts of a force whose command had the elastic direction `elastic`: what lies along it is
/// elastic, the rest frictional. Used by the modes that bound the whole force and must still report
/// its parts.
template <class Real>
inline BasicCommand<Real> split_along(const Vector3<Real>& force,
                                      const Vector3<Real>& elastic) noexcept {
  BasicCommand<Real> parts;
  parts.elastic = along(force, direction(elastic));
  parts.frictional = force - parts.elastic;
  return parts;
}

}  // namespace feltwire
