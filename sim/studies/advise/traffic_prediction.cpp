#include "sim/studies/advise/traffic_prediction.hpp"

#include <algorithm>
#include <cmath>

#include "client/emulated_link/link_model.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"

namespace feltwire::advise {
namespace {

constexpr std::size_t kAroundPayload = kMaxDatagram - kMaxPayload + kHeadersOnTheWire;

/// Returns the datagrams from one reply to the next where the force deadband withholds replies
/// until the keep-alive time (server/scene/reply_deadband.cpp).
double intervals_of_silence(const SessionParameters& p) {
  const double interval = p.packet_interval * p.servo_period;
  const double waits = p.keep_alive - interval + 0.5 * p.servo_period;
  return std::max(1.0, std::ceil(waits / interval));
}

}  // namespace

std::size_t sample_datagram(int samples, bool rotation) {
  SampleBatch batch;
  batch.count = samples;
  batch.rotation = rotation;
  batch.previous = 1;
  for (int i = 0; i < samples; ++i)
    batch.samples[static_cast<std::size_t>(i)].index =
        batch.previous + static_cast<std::uint64_t>(samples - i);
  Encoder encoder;
  return encoder.samples(batch).size() + kAroundPayload;
}

Traffic traffic_of(const SessionParameters& p, const DeviceSpec& device,
                   const TwoWayLinkOptions& link, std::size_t reply_payload, bool changes) {
  Traffic traffic;
  const double interval = p.packet_interval * p.servo_period;
  traffic.up = {interval, static_cast<double>(
                              sample_datagram(p.batch + p.redundancy, device.rotation_sensed > 0))};
  traffic.down.bytes = static_cast<double>(reply_payload + kAroundPayload);
  const double arrive = 1.0 - losses(link.up).share;
  if (p.force_deadband > 0.0 && !changes) {
    // A reply is due with the first datagram that arrives after the keep-alive time.
    const double late = arrive > 0.0 ? (1.0 - arrive) / arrive : 0.0;
    traffic.down.interval = (intervals_of_silence(p) + late) * interval;
  } else {
    traffic.down.interval = arrive > 0.0 ? interval / arrive : interval;
  }
  traffic.answered = interval / traffic.down.interval;
  return traffic;
}

}  // namespace feltwire::advise
