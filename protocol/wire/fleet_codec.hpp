#pragma once
// Internal to protocol/wire: the hosts of a fleet in control messages.

#include <vector>

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_generated.h"

namespace feltwire::control {

using WireHosts = flatbuffers::Vector<flatbuffers::Offset<wire::FleetHost>>;

/// 0 where there is none.
flatbuffers::Offset<WireHosts> build(flatbuffers::FlatBufferBuilder& builder,
                                     const std::vector<FleetHost>& hosts);
flatbuffers::Offset<wire::Redirected> build(flatbuffers::FlatBufferBuilder& builder,
                                            const Redirected& redirected);

/// `hosts`: null where there is none. False: there are too many, a text is too long, or a
/// fingerprint has another length.
bool read(const WireHosts* hosts, std::vector<FleetHost>& to);
bool read(const wire::Redirected& from, Redirected& to);

}  // namespace feltwire::control
