#pragma once
// Internal to protocol/wire: the messages that bring meshes in full.

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_generated.h"

namespace feltwire::control {

flatbuffers::Offset<wire::SurfaceList> build(flatbuffers::FlatBufferBuilder& builder,
                                             const SurfaceList& list);
flatbuffers::Offset<wire::SurfacePart> build(flatbuffers::FlatBufferBuilder& builder,
                                             const SurfacePart& part);

/// False if it has more entries than a message may have. Numbers are not checked.
bool read(const wire::SurfaceList& from, SurfaceList& to);
bool read(const wire::SurfacePart& from, SurfacePart& to);
bool read(const wire::TakeSurfaces& from, TakeSurfaces& to);

}  // namespace feltwire::control
