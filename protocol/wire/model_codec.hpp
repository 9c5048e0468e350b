#pragma once
// Internal to the codec: the local model of a point or a ball, to bytes and back.

#include "core/local_model/local_model.hpp"
#include "protocol/wire/datagram_generated.h"

namespace feltwire {

/// Writes the model: the first kMaxPatches patches, and their offsets if any is not zero. It does
/// not allocate if the builder has room.
flatbuffers::Offset<wire::LocalModel> build(flatbuffers::FlatBufferBuilder& builder,
                                            const LocalModel& model);

/// False if it has more patches than a model may have, offsets for another number of patches, or
/// whole patches without a version of the surfaces.
bool read(const wire::LocalModel& from, LocalModel& to) noexcept;
/// Whether every number is finite and possible for a surface.
bool plausible(const LocalModel& model) noexcept;

/// Whether the length of a vector is 1 within the rounding of the wire (kUnitTolerance).
bool unit_length(const Vec3& v) noexcept;

}  // namespace feltwire
