// Busy polling of a server or client must not change its behaviour.

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/client/loopback.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::busy_poll_test {
namespace {

using testing::Client;
using testing::kPatience;
using testing::kStroke;

/// The parameter is the server's busy_poll [us].
class BusyServer : public ::testing::TestWithParam<double> {
 protected:
  static ServerConfig config() {
    ServerConfig config = testing::any_ports();
    config.busy_poll = GetParam();
    return config;
  }
  static std::unique_ptr<Server> server(const ServerConfig& config) {
    std::vector<Scene> scenes;
    scenes.push_back(testing::floor_scene());
    return std::make_unique<Server>(config, std::move(scenes), test::security());
  }
};

/// Receives until a goodbye comes.
Transport::Arrival await_goodbye(Transport& transport, GoodbyeReason& reason) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  Reply reply;
  auto arrival = Transport::Arrival::nothing;
  while (arrival != Transport::Arrival::goodbye && std::chrono::steady_clock::now() < end)
    arrival = transport.receive(reply, reason);
  return arrival;
}

Sample still(std::uint64_t index) {
  Sample sample;
  sample.index = index;
  sample.pose.position = {0, 0, 0.01};
  return sample;
}

TEST_P(BusyServer, AnswersHandsAndRequests) {
  const auto served = server(config());
  const ServerAccess endpoint = test::access(served->control_port());
  Client hand(endpoint, kStroke, {}, "floor");
  hand.start();
  for (std::uint32_t others = 1; others <= 5; ++others) {
    join(endpoint, {"other", "floor", hand.device.spec(), {}}, kPatience);
    EXPECT_GE(list_scenes(endpoint, kPatience).front().sessions, others);
  }
  hand.finish();
  EXPECT_EQ(hand.result->end, EndReason::device_ended);
  EXPECT_GT(hand.servo.statistics().replies.answered, 0u);
  EXPECT_GT(hand.servo.statistics().max_force, 0.01);  // [N] A busy machine reduces the force.
  EXPECT_EQ(hand.transport.statistics().dropped, TransportStatistics{}.dropped);
}

TEST_P(BusyServer, ASilentSessionEnds) {
  ServerConfig impatient = config();
  impatient.silence_timeout = 1.0;  // [s] long enough for the first sample on a busy machine
  const auto served = server(impatient);
  Client hand(test::access(served->control_port()), kStroke, {}, "floor");
  hand.transport.send(still(1));
  GoodbyeReason reason = GoodbyeReason::leaving;
  ASSERT_EQ(await_goodbye(hand.transport, reason), Transport::Arrival::goodbye);
  EXPECT_EQ(reason, GoodbyeReason::evicted);
}

TEST_P(BusyServer, StopsWithAGoodbye) {
  const auto served = server(config());
  Client hand(test::access(served->control_port()), kStroke, {}, "floor");
  hand.transport.send(still(1));
  Reply reply;
  GoodbyeReason reason = GoodbyeReason::leaving;
  test::eventually("the answer", [&] {
    return hand.transport.receive(reply, reason) == Transport::Arrival::reply;
  });
  served->stop();
  ASSERT_EQ(await_goodbye(hand.transport, reason), Transport::Arrival::goodbye);
  EXPECT_EQ(reason, GoodbyeReason::shutting_down);
}

/// A peer that keeps the socket full must not block requests or the server's shutdown.
TEST_P(BusyServer, AFloodKeepsNobodyOut) {
  const auto served = server(config());
  const ServerAccess endpoint = test::access(served->control_port());
  Client hand(endpoint, kStroke, {}, "floor");
  std::atomic<bool> flooding{true}, answered{false};
  std::thread flood([&] {
    Reply reply;
    GoodbyeReason reason;
    for (std::uint64_t index = 1; flooding; ++index) {
      hand.transport.send(still(index));
      if (!answered) answered = hand.transport.receive(reply, reason) == Transport::Arrival::reply;
    }
  });
  EXPECT_TRUE(test::becomes([&] { return answered.load(); }));
  for (int i = 0; i < 5; ++i)
    EXPECT_NO_THROW(join(endpoint, {"other", "floor", hand.device.spec(), {}}, kPatience));
  served->stop();
  flooding = false;
  flood.join();
  const auto summary = served->summary();
  EXPECT_EQ(summary.front().counters.sessions_served, 6u);
  EXPECT_GT(summary.front().counters.samples.samples, 0u);
}

INSTANTIATE_TEST_SUITE_P(BusyPoll, BusyServer, ::testing::Values(0.0, 50.0, HUGE_VAL));

/// Returns the number of other running threads of this process.
int threads_awake() {
  int awake = 0;
  const std::string self = std::filesystem::read_symlink("/proc/thread-self").filename();
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (task.path().filename() == self) continue;
    std::ifstream file(task.path() / "stat");
    std::string line;
    std::getline(file, line);
    const std::size_t name_end = line.rfind(')');  // The thread state follows the name.
    if (name_end != std::string::npos && line.size() > name_end + 2 && line[name_end + 2] == 'R')
      ++awake;
  }
  return awake;
}

TEST(BusyPoll, ABoundedOneSleepsWhenNothingComes) {
  ServerConfig config = testing::any_ports();
  config.busy_poll = 1000.0;
  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  Server server(config, std::move(scenes), test::security());
  Client hand(test::access(server.control_port()), kStroke, {}, "floor");
  hand.transport.send(still(1));
  // All threads must sleep in many consecutive checks. A single check could succeed by chance.
  const auto end = std::chrono::steady_clock::now() + kPatience;
  constexpr int kTimes = 100;
  for (int asleep = 0; asleep < kTimes;) {
    asleep = threads_awake() == 0 ? asleep + 1 : 0;
    ASSERT_LT(std::chrono::steady_clock::now(), end);
  }
}

/// The parameter is the client's busy_poll. All other tests use 0.
class BusyClient : public ::testing::TestWithParam<Nanoseconds> {};

TEST_P(BusyClient, KeepsItsDeadlinesAndTakesItsReplies) {
  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  const Server server(testing::any_ports(), std::move(scenes), test::security());
  Client hand(test::access(server.control_port()), kStroke, {}, "floor");
  hand.start({.silence_timeout = kPatience, .busy_poll = GetParam()});
  hand.finish();
  EXPECT_EQ(hand.result->end, EndReason::device_ended);
  EXPECT_EQ(hand.servo.statistics().replies.answered, hand.servo.statistics().samples);
  EXPECT_EQ(hand.servo.statistics().samples, hand.result->wakeup_late.count() + 1);
  EXPECT_GT(hand.servo.statistics().max_force, 0.01);  // [N] A busy machine reduces the force.
}

TEST_P(BusyClient, ServesAnEmulatedLink) {
  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  const Server server(testing::any_ports(), std::move(scenes), test::security());
  SessionParameters slow;
  slow.servo_period = 0.02;
  Client hand(test::access(server.control_port()), kStroke, slow, "floor",
              std::make_unique<TwoWayLink>(parse_link("delay=3"), 0, 1 << 10));
  hand.start({.silence_timeout = kPatience, .busy_poll = GetParam()});
  hand.finish();
  EXPECT_EQ(hand.servo.statistics().replies.answered, hand.servo.statistics().samples);
  const Histogram& round_trip = hand.servo.statistics().replies.round_trip;  // [ns]
  EXPECT_GE(round_trip.quantile(0.0), 5.9e6);
  // [ns] The client must take a reply before its next tick.
  EXPECT_LT(round_trip.quantile(0.5), 20e6);
}

TEST_P(BusyClient, EndsWhenAskedOrLeftAlone) {
  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  Server server(testing::any_ports(), std::move(scenes), test::security());
  const ServerAccess endpoint = test::access(server.control_port());
  Client asked(endpoint, "t,x,y,z\n0,0,0,0.005\n100,0,0,0.005\n", {}, "floor");
  Client left(endpoint, "t,x,y,z\n0,0,0,0.005\n100,0,0,0.005\n", {}, "floor");
  asked.start({.silence_timeout = kPatience, .busy_poll = GetParam()});
  left.start({.silence_timeout = kPatience, .busy_poll = GetParam()});
  // The server sends its goodbye to the sender of the samples.
  TickRecord row;
  test::eventually("an answer", [&] { return left.records.pop(row) && row.age >= 0.0; });
  asked.stop.set();
  asked.finish();
  EXPECT_EQ(asked.result->end, EndReason::requested);
  server.stop();
  left.finish();
  EXPECT_EQ(left.result->end, EndReason::server_goodbye);
}

INSTANTIATE_TEST_SUITE_P(BusyPoll, BusyClient,
                         ::testing::Values(std::chrono::microseconds(100), kForever));

TEST(BusyPoll, WhatNeverSleeps) {
  const Nanoseconds period = std::chrono::milliseconds(1);
  EXPECT_FALSE(never_sleeps(Nanoseconds(0), period));
  EXPECT_FALSE(never_sleeps(std::chrono::microseconds(100), period));
  EXPECT_TRUE(never_sleeps(period / 2, period));
  EXPECT_TRUE(never_sleeps(kForever, period));
}

TEST(BusyPoll, InMicroseconds) {
  EXPECT_EQ(busy_poll_time(0), Nanoseconds(0));
  EXPECT_EQ(busy_poll_time(50), std::chrono::microseconds(50));
  EXPECT_EQ(busy_poll_time(HUGE_VAL), kForever);
  EXPECT_TRUE(possible_busy_poll(0.0) && possible_busy_poll(1e6) && possible_busy_poll(HUGE_VAL));
  EXPECT_FALSE(possible_busy_poll(-1.0) || possible_busy_poll(1.1e6) || possible_busy_poll(NAN));
}

}  // namespace
}  // namespace feltwire::busy_poll_test
