#pragma once
// Internal to protocol/wire: the parts of control messages that say what a session is: its device,
// its parameters, and the workspace of a robot.

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_generated.h"

namespace feltwire::control {

flatbuffers::Offset<wire::DeviceSpec> build(flatbuffers::FlatBufferBuilder& builder,
                                            const DeviceSpec& device);
flatbuffers::Offset<wire::SessionParameters> build(flatbuffers::FlatBufferBuilder& builder,
                                                   const SessionParameters& parameters);
/// Nothing where there are no limits.
flatbuffers::Offset<wire::Workspace> build(flatbuffers::FlatBufferBuilder& builder,
                                           const Workspace& workspace);

/// False for what the types cannot hold. validate() checks the numbers of a device and of
/// parameters.
bool read(const wire::DeviceSpec& from, DeviceSpec& to);
bool read(const wire::SessionParameters& from, SessionParameters& to);
/// Null: it stays without limits.
bool read(const wire::Workspace* from, Workspace& to);

}  // namespace feltwire::control
