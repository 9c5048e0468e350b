#pragma once
// A tool with a body in a world. Static and moving objects answer it together: the tool finds one
// balance between all of them and the hand.

#include "core/dynamics/body_contact_state.hpp"
#include "core/dynamics/moving_objects.hpp"

namespace feltwire {

/// The command at a sample of the hand, as World::touch() for a tool with a body. Never allocates.
Command touch(const MovingObjects& objects, const WorldMoment& moment, const Pose& device,
              const Vec3& velocity, double elapsed, BodyMemory& memory,
              BodyContactState& contacts) noexcept;
/// Computes the forces of `contacts` for a step without a new sample: the hand is assumed to stand
/// still. After a sample they stay. Returns false if the contacts are those of another world.
bool hold_still(const MovingObjects& objects, const WorldMoment& moment, BodyMemory& memory,
                BodyContactState& contacts) noexcept;

}  // namespace feltwire
