// Tests a client with an emulated link against a complete server.

#include <gtest/gtest.h>

#include "tests/client/loopback.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::link_loopback_test {
namespace {

using testing::Client;
using testing::kStroke;
using testing::Loopback;

class LinkLoopback : public Loopback {};

/// Returns the expected number of answers to `samples`. Without queue, duplicates and reordering,
/// the server answers each datagram once. The loss of a datagram then depends only on its number.
std::uint64_t expected_answers(const TwoWayLinkOptions& link, std::uint64_t samples) {
  LinkModel up(link.up, link_key(link.seed, 0, LinkDirection::up));
  LinkModel down(link.down, link_key(link.seed, 0, LinkDirection::down));
  std::uint64_t answered = 0;
  for (std::uint64_t i = 0; i < samples; ++i)
    if (up.next(200, Nanoseconds(0)).copies > 0)
      answered += static_cast<std::uint64_t>(down.next(200, Nanoseconds(0)).copies);
  return answered;
}

TEST_F(LinkLoopback, WhatIsLostIsWhatTheModelLost) {
  const TwoWayLinkOptions options = parse_link("delay=3,loss=15,down.burst=4,seed=3");
  Client client(endpoint, kStroke, {}, "floor", std::make_unique<TwoWayLink>(options, 0, 1024));
  client.start();
  client.finish();

  const ServoStatistics& s = client.servo.statistics();
  EXPECT_EQ(client.result->end, EndReason::device_ended);
  EXPECT_EQ(s.replies.answered, expected_answers(options, s.samples));
  EXPECT_LT(s.replies.answered, s.samples);
  EXPECT_EQ(client.servo.port().violations(), 0u);
  EXPECT_GT(s.max_force, 0.0);

  const LinkStatistics up = client.link()->up.statistics();
  const LinkStatistics down = client.link()->down.statistics();
  EXPECT_EQ(up.entered, s.samples);
  EXPECT_EQ(down.entered, up.delivered);  // one answer per datagram
  EXPECT_EQ(down.delivered, s.replies.answered);
  EXPECT_EQ(up.in_flight + down.in_flight, 0u);  // The client must wait for the last answers.
  EXPECT_GE(up.least_delay, std::chrono::milliseconds(3));
  EXPECT_GE(down.least_delay, std::chrono::milliseconds(3));
  EXPECT_GE(s.replies.round_trip.quantile(0.0), 6e6 * 0.99);  // The histogram rounds its values.

  // Wait for the client's goodbyes, because a server that stops first would end the session itself.
  test::eventually("the end of the session",
                   [&] { return list_scenes(endpoint, testing::kPatience).at(0).sessions == 0; });
  server->stop();
  const auto summary = server->summary();
  EXPECT_EQ(summary[0].counters.left, 1u);  // The emulated link loses no goodbyes.
  EXPECT_EQ(summary[0].counters.datagrams, up.delivered + 3);
}

TEST_F(LinkLoopback, AHandOverAHostileLinkIsSafe) {
  const TwoWayLinkOptions options = parse_link("hostile,delay=8,jitter=6,seed=5");
  Client client(endpoint, kStroke, {}, "floor", std::make_unique<TwoWayLink>(options, 0, 1024));
  client.start();
  client.finish();
  const ServoStatistics& s = client.servo.statistics();
  EXPECT_EQ(client.result->end, EndReason::device_ended);
  EXPECT_EQ(client.servo.port().violations(), 0u);
  EXPECT_GT(s.replies.answered, 0u);
  EXPECT_EQ(client.servo.held().force(), Vec3::Zero());
  const LinkStatistics up = client.link()->up.statistics();
  EXPECT_GT(up.lost, 0u);
  EXPECT_GT(up.duplicated, 0u);
  EXPECT_GT(up.reordered, 0u);
}

TEST_F(LinkLoopback, ACutCableEndsInSilence) {
  const TwoWayLinkOptions options = parse_link("down.loss=100");
  Client client(endpoint, "t,x,y,z\n0,0,0,-0.001\n1000,0,0,-0.001\n", {}, "floor",
                std::make_unique<TwoWayLink>(options, 0, 1024));
  LoopOptions limits;
  limits.silence_timeout = std::chrono::milliseconds(50);
  client.start(limits);
  client.finish();
  EXPECT_EQ(client.result->end, EndReason::server_silent);
  EXPECT_EQ(client.servo.statistics().replies.answered, 0u);
  EXPECT_EQ(client.servo.statistics().max_force, 0.0);
}

}  // namespace
}  // namespace feltwire::link_loopback_test
