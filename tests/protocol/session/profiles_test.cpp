#include "protocol/session/profiles.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <stdexcept>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/scene_view.hpp"

namespace feltwire::profiles_test {
namespace {

TEST(Profiles, HaveNames) {
  for (const NetworkProfile& profile : kNetworkProfiles)
    EXPECT_EQ(&network_profile(profile.name), &profile);
  EXPECT_EQ(network_profile_names(), "lan|wan|thin");
  try {
    network_profile("moon");
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("choose one of: lan wan thin"));
  }
}

TEST(Profiles, AreGoodAtEveryServoRateAndMode) {
  for (const NetworkProfile& profile : kNetworkProfiles)
    for (const double rate : {10.0, 100.0, 250.0, 1000.0, 4000.0, 1e4, 1e5})
      for (const std::string_view mode : bounding_method_names()) {
        SessionParameters p;
        p.mode = mode;
        if (stands_beside_scene(bounding_method(p.mode))) p.side = BoundingSide::server;
        p.servo_period = 1.0 / rate;
        p.hold_time = std::max(p.hold_time, p.servo_period);
        const SessionParameters there = over(profile, p);
        EXPECT_NO_THROW(validate(there)) << profile.name << ' ' << rate << ' ' << p.mode;
        EXPECT_EQ(there.servo_period, p.servo_period);
        EXPECT_EQ(there.mode, p.mode);
        // The number of datagrams must fill the line, within whole ticks and at most 1000 ticks.
        if (rate >= profile.packet_rate && rate <= 1000.0 * profile.packet_rate) {
          EXPECT_NEAR(rate / there.packet_interval, profile.packet_rate,
                      0.34 * profile.packet_rate);
        }
      }
}

TEST(Profiles, AreWhatTheDefaultsAreOnALan) {
  EXPECT_EQ(over(network_profile("lan"), {}), SessionParameters{});
}

// The test covers every scene with the largest reply to every datagram, with rotation, in both
// directions.
TEST(Profiles, AThinLineHasRoomForAllOfIt) {
  constexpr double kRoom = 64e3;        // [bit/s] capacity of the line
  constexpr std::size_t kHeaders = 28;  // [bytes] headers of UDP and IPv4
  const SessionParameters p = over(network_profile("thin"), {});
  Encoder encoder;
  SampleBatch samples;
  samples.rotation = true;
  samples.count = p.batch + p.redundancy;
  for (int i = 0; i < samples.count; ++i)
    samples.samples[static_cast<std::size_t>(i)].index =
        static_cast<std::uint64_t>(samples.count - i);
  Reply reply;
  reply.rotation = reply.modelled = true;
  reply.predicted = p.predictor == Predictor::linear;
  reply.model.count = kMaxPatches;
  const double rate = 1.0 / (p.packet_interval * p.servo_period);
  const auto bits = [&](Bytes payload) {
    return 8.0 * rate * static_cast<double>(payload.size() + kOverhead + kHeaders);
  };
  EXPECT_LT(bits(encoder.samples(samples)), kRoom);
  EXPECT_LT(bits(encoder.reply(reply)), kRoom);
  // An observer's view must also fit.
  reply.modelled = false;
  SceneView view;
  view.present = true;
  view.hand_count = view_room(p.packet_interval * p.servo_period) / SceneView::kHandSize;
  EXPECT_GT(view.hand_count, 4u);
  EXPECT_LT(bits(encoder.reply(reply, &view)), kRoom);
}

TEST(Profiles, AServerGrantsWhatItsLineHasRoomFor) {
  const NetworkProfile& thin = network_profile("thin");
  EXPECT_EQ(granted(thin, {}), over(thin, {}));
  SessionParameters modest;
  modest.packet_interval = 100;
  EXPECT_EQ(granted(thin, modest), modest);
  SessionParameters bound_at_server;
  bound_at_server.side = BoundingSide::server;
  EXPECT_EQ(granted(thin, bound_at_server).side, BoundingSide::client);
  EXPECT_EQ(granted(network_profile("lan"), {}), SessionParameters{});
  // A sufficient hold time must stay. The keep-alive interval must become shorter.
  const SessionParameters over_wan = granted(network_profile("wan"), {});
  EXPECT_EQ(over_wan.hold_time, SessionParameters{}.hold_time);
  EXPECT_DOUBLE_EQ(over_wan.keep_alive, 0.02);
  EXPECT_EQ(over_wan.packet_interval, 10);
  EXPECT_NO_THROW(validate(over_wan));
  EXPECT_EQ(forbidden_grant({}, over_wan), std::nullopt);
  SessionParameters long_hold;
  long_hold.hold_time = 1.0;
  EXPECT_EQ(granted(network_profile("wan"), long_hold), over(network_profile("wan"), long_hold));
}

}  // namespace
}  // namespace feltwire::profiles_test
