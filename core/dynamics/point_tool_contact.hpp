#pragma once
// A point or a ball in a world: which moving objects it asks, and how they answer.

#include "core/dynamics/body_contact_state.hpp"
#include "core/dynamics/moving_objects.hpp"

namespace feltwire {

/// The command at a sample of the hand, as World::touch() for a point or a ball. Never allocates.
Command touch(const MovingObjects& objects, const WorldMoment& moment, const Tool& tool,
              TouchMemory& memory, BodyContactState& contacts) noexcept;
/// Computes the forces of `contacts` for a step without a new sample: the hand is assumed to stand
/// still. After a sample they stay. Returns false if the contacts are those of another world.
bool hold_still(const MovingObjects& objects, const WorldMoment& moment, TouchMemory& memory,
                BodyContactState& contacts) noexcept;

}  // namespace feltwire
