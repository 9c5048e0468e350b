#pragma once
// Internal to the codec: the local model of a tool with a body, to bytes and back.

#include "core/local_model/body_model.hpp"
#include "protocol/wire/datagram_generated.h"

namespace feltwire {

/// Writes the model. Numbers that cannot be told in 16 bits become the nearest that can. Does not
/// allocate where the builder has room.
flatbuffers::Offset<wire::BodyModel> build(flatbuffers::FlatBufferBuilder& builder,
                                           const BodyModel& model);

/// False when it has more points, patches or solids than a model may have, or a point has a patch
/// that is not there. A model with a solid of no known kind has no reach.
bool read(const wire::BodyModel& from, BodyModel& to) noexcept;
/// Every number is finite and one that a tool, a spring and a surface can have.
bool plausible(const BodyModel& model) noexcept;

}  // namespace feltwire
