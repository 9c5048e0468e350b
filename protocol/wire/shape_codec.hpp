#pragma once
// Internal to protocol/wire: the messages that describe the shapes of a scene.

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_generated.h"

namespace feltwire::control {

flatbuffers::Offset<wire::DescribeShapes> build(flatbuffers::FlatBufferBuilder& builder,
                                                const DescribeShapes& request);
flatbuffers::Offset<wire::ShapeDescriptions> build(flatbuffers::FlatBufferBuilder& builder,
                                                   const ShapeDescriptions& list);
flatbuffers::Offset<wire::GetShape> build(flatbuffers::FlatBufferBuilder& builder,
                                          const GetShape& request);
flatbuffers::Offset<wire::ShapePart> build(flatbuffers::FlatBufferBuilder& builder,
                                           const ShapePart& part);

/// False if a list is longer than a message may have, or a group is unknown. Numbers are not
/// checked.
bool read(const wire::DescribeShapes& from, DescribeShapes& to);
bool read(const wire::ShapeDescriptions& from, ShapeDescriptions& to);
bool read(const wire::GetShape& from, GetShape& to);
bool read(const wire::ShapePart& from, ShapePart& to);

}  // namespace feltwire::control
