#pragma once
// The datagrams of a session, from the bytes of the protocol's own encoder.

#include "core/device/device_spec.hpp"
#include "sim/studies/advise/link_prediction.hpp"

namespace feltwire::advise {

struct Traffic {
  Flow up, down;          // as they are sent, the headers of UDP and IPv4 included
  double answered = 1.0;  // replies for each datagram that is sent up
};

/// `reply_payload` [bytes] of a reply, as cost_at() finds it. `changes`: the surfaces or the force
/// change by more than the force deadband from one datagram to the next, as for a hand that moves.
Traffic traffic_of(const SessionParameters& parameters, const DeviceSpec& device,
                   const TwoWayLinkOptions& link, std::size_t reply_payload, bool changes);

/// [bytes] of a datagram with so many samples, with all headers.
std::size_t sample_datagram(int samples, bool rotation);

}  // namespace feltwire::advise
