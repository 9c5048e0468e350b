#pragma once

#include "core/numeric.hpp"
#include "core/types.hpp"

namespace feltwire {

/// Parts of a force whose command had the elastic direction `elastic`: what lies along it is
/// elastic, the rest frictional. Used by the modes that bound the whole force and must still report
/// its parts.
inline Command split_along(const Vec3& force, const Vec3& elastic) noexcept {
  Command parts;
  parts.elastic = along(force, direction(elastic));
  parts.frictional = force - parts.elastic;
  return parts;
}

}  // namespace feltwire
