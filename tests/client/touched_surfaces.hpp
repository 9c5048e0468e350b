#pragma once
// Replies that say that the tool touches a whole surface.

#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire::testing {

/// The model of the reply is one surface of the version `surfaces`, touched at `hand` [m].
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
