#pragma once
// Replies that report contact with a whole surface.

#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire::testing {

/// Makes the reply's model a surface of version `surfaces`, touched at `hand` [m].
inline void mark_as_touched(Reply& reply, std::uint32_t surfaces, const Vec3& hand) {
  reply.modelled = true;
  reply.model.surfaces = surfaces;
  reply.model.center = hand;
  reply.model.reach = 0.1;
  reply.model.count = 1;
  SurfacePatch& patch = reply.model.patches[0];
  patch.point = patch.anchor = hand;
  patch.whole = patch.touching = true;
  patch.material = {.stiffness = 2000.0, .static_friction = 0.5, .dynamic_friction = 0.4};
}

}  // namespace feltwire::testing
