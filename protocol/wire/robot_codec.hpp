#pragma once
// Internal to the codec: the messages about robots, as values and as structs of the schema.

#include "core/teleoperation/robot.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/datagram_generated.h"

namespace feltwire {

wire::Lead wire_lead(const Lead& lead);
Lead value(const wire::Lead& from);
/// Finite, and possible as an offset between two places of hands.
bool plausible(const Lead& lead) noexcept;

wire::Remote wire_remote(const Remote& remote);
/// False if a number in it is impossible.
bool read(const wire::Remote& from, Remote& to) noexcept;

/// Empty if there are none.
flatbuffers::Offset<flatbuffers::Vector<const wire::RobotWall*>> build_walls(
    flatbuffers::FlatBufferBuilder& builder, const std::optional<Remote>& remote);
/// Precondition: at most kMostRemoteWalls, aligned. False if a number in them is impossible.
bool read(const flatbuffers::Vector<const wire::RobotWall*>& from, Remote& to) noexcept;

using WireSurfaces = flatbuffers::Vector<const wire::RobotContact*>;
/// Empty if there are none.
flatbuffers::Offset<WireSurfaces> build_others(flatbuffers::FlatBufferBuilder& builder,
                                               const OtherSurfaces& others);
/// Fills `to`, with none if `from` is null. `malformed`, `count` or `not_finite` if it cannot.
DropReason read(const WireSurfaces* from, OtherSurfaces& to) noexcept;

flatbuffers::Offset<wire::FollowerState> build(flatbuffers::FlatBufferBuilder& builder,
                                               const RobotState& state);
flatbuffers::Offset<wire::FollowerTarget> build(flatbuffers::FlatBufferBuilder& builder,
                                                const RobotTarget& target);

/// The `turn` of a reply. False if no rotation vector has this length.
bool read(const wire::Vec3f& turn, Remote& to) noexcept;

}  // namespace feltwire
