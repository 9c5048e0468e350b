#pragma once
// Fetches what a server offers of a scene, part by part.
//
// A server can answer without end. Therefore a fetch ends with a reason as soon as a part goes
// beyond what was announced, or brings nothing of what is missing.

#include <cstdint>
#include <vector>

#include "client/transport/control_dialogue.hpp"
#include "core/local_model/prefetched_geometry.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// The surfaces of a list that have room (FetchRoom), in its order. Throws SessionError;
/// FalseAnswer if the list or a part is not possible.
std::vector<SurfaceData> fetched_surfaces(ControlDialogue& dialogue, std::uint64_t session,
                                          const control::SurfaceList& list);

/// The solids of a list that have room, in its order. Throws as fetched_surfaces().
std::vector<SolidData> fetched_solids(ControlDialogue& dialogue, std::uint64_t session,
                                      const control::SolidList& list);

/// The body of a list with its points. Throws as fetched_surfaces(). Precondition: the list has a
/// body, of at most kMostBodyPoints points.
BodyData fetched_body(ControlDialogue& dialogue, std::uint64_t session,
                      const control::SolidList& list);

}  // namespace feltwire
