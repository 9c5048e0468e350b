#include "protocol/session/profiles.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/enum_names.hpp"

namespace feltwire {
namespace {

int interval(const NetworkProfile& line, double servo_period) {
  return std::clamp(static_cast<int>(std::lround(1.0 / (line.packet_rate * servo_period))), 1,
                    kMaxPacketInterval);
}

}  // namespace

const NetworkProfile& network_profile(std::string_view given) {
  return get_named("network profile", given, kNetworkProfiles, &NetworkProfile::name);
}

std::string network_profile_names() {
  return joined_names(kNetworkProfiles, "|", &NetworkProfile::name);
}

SessionParameters over(const NetworkProfile& line, SessionParameters p) {
  p.packet_interval = interval(line, p.servo_period);
  p.redundancy = line.redundancy;
  p.batch = std::min({line.batch, p.packet_interval, kMaxRedundancy + 1 - p.redundancy});
  p.position_deadband = line.position_deadband;
  p.force_deadband = line.force_deadband;
  p.predictor = line.predictor;
  // If the servo is slow, one packet interval may exceed the profile's times.
  const double between = p.packet_interval * p.servo_period;
  p.keep_alive = std::max(line.keep_alive, between);
  p.hold_time = std::max(line.hold_time, 2.0 * between);
  // A method beside the scene uses no local model.
  p.local_model = line.local_model && !stands_beside_scene(bounding_method(p.mode));
  if (p.local_model && p.side == BoundingSide::server) p.side = BoundingSide::client;
  return p;
}

SessionParameters granted(const NetworkProfile& line, const SessionParameters& p) {
  if (p.packet_interval >= interval(line, p.servo_period)) return p;
  // Number of packet intervals without a packet after which a command still applies.
  constexpr double kSilences = 5.0;
  SessionParameters whole = over(line, p);
  const double between = whole.packet_interval * whole.servo_period;
  // By default, a client does not accept a longer hold time. So keep the given hold time if the
  // profile permits it.
  if (whole.hold_time <= p.hold_time || kSilences * between > p.hold_time) return whole;
  SessionParameters kept = whole;
  kept.hold_time = p.hold_time;
  kept.keep_alive = std::clamp(p.hold_time / kSilences, between, whole.keep_alive);
  return kept;
}

}  // namespace feltwire
