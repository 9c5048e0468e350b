#pragma once
// Internal to the codec: the local model of a tool with a body, to bytes and back.

#include "core/local_model/body_model.hpp"
#include "protocol/wire/datagram_generated.h"

namespace feltwire {

/// Writes the model. Numbers that do not fit 16 bits are rounded to the nearest possible. It does
/// not allocate if the builder has room.
flatbuffers::Offset<wire::BodyModel> build(flatbuffers::FlatBufferBuilder& builder,
                                           const BodyModel& model);

/// False if it has more points or patches than a model may have, or a point has a missing patch.
bool read(const wire::BodyModel& from, BodyModel& to) noexcept;
/// Whether every number is finite and possible for a tool, a spring and a surface.
bool plausible(const BodyModel& model) noexcept;

}  // namespace feltwire
