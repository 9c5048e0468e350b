#pragma once
// Internal to protocol/wire: the messages that bring a tool with a body and its solids in full.

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_generated.h"

namespace feltwire::control {

flatbuffers::Offset<wire::SolidList> build(flatbuffers::FlatBufferBuilder& builder,
                                           const SolidList& list);
flatbuffers::Offset<wire::BodyPoints> build(flatbuffers::FlatBufferBuilder& builder,
                                            const BodyPoints& part);

/// False if it has more entries than a message may have, or a shape without all of its numbers.
/// Solids of shapes that this program does not know are left out. Numbers are not checked.
bool read(const wire::SolidList& from, SolidList& to);
bool read(const wire::BodyPoints& from, BodyPoints& to);

}  // namespace feltwire::control
