// Tests a complete server in this process, with real sockets on free ports.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>

#include "protocol/net/real_time.hpp"
#include "server/app/server.hpp"
#include "tests/core/moving.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire::loopback_test {
namespace {

using test::any_port;
using test::ControlClient;
using test::RawSocket;

/// The UDP side of a client.
struct DatagramClient {
  control::JoinAccepted joined;
  RawSocket socket;
  SessionKeys keys;
  test::SealedEncoder encoder;
  std::uint64_t packet = 0;

  explicit DatagramClient(const test::JoinedBy& by)
      : joined(by.accepted),
        socket(SOCK_DGRAM, by.udp_port),
        keys(by.keys),
        encoder(test::Way::up, keys) {}

  std::vector<std::uint8_t> opened(Bytes bytes) const {
    return test::opened(bytes, test::Way::down, keys);
  }

  Reply exchange(const SampleBatch& batch) {
    socket.send(encoder.samples(joined.session, ++packet, batch));
    const auto bytes = socket.receive();
    const Guarded guarded = guard(bytes, test::kAllKinds);
    Reply reply;
    if (guarded.drop != DropReason::none || guarded.header.kind != DatagramKind::reply ||
        guarded.header.session != joined.session ||
        decode(opened(bytes), reply) != DropReason::none)
      throw std::runtime_error("no reply");
    return reply;
  }
  GoodbyeReason await_goodbye() {
    const auto bytes = socket.receive();
    const Guarded guarded = guard(bytes, test::kAllKinds);
    GoodbyeReason reason = GoodbyeReason::leaving;
    if (guarded.drop != DropReason::none || guarded.header.kind != DatagramKind::goodbye ||
        decode(opened(bytes), reason) != DropReason::none)
      throw std::runtime_error("no goodbye");
    return reason;
  }
};

std::vector<Scene> two_scenes() {
  return {test::room(), Scene("ball", {test::room().objects()[1]})};
}

/// The kernel must give each scene the datagrams of its own sessions alone.
TEST(Loopback, AllScenesShareAPort) {
  Server server(any_port(), two_scenes(), test::security());
  ControlClient control(server.control_port());
  const test::JoinedBy room = control.join(test::join_request());
  control::JoinRequest request = test::join_request();
  request.scene = "ball";
  const test::JoinedBy ball = control.join(request);
  EXPECT_EQ(room.udp_port, ball.udp_port);
  DatagramClient a(room), b(ball);
  for (std::uint64_t n = 1; n <= 100; ++n) {
    ASSERT_EQ(a.exchange(test::hand_batch(n)).sample_index, n);
    ASSERT_EQ(b.exchange(test::hand_batch(n)).sample_index, n);
  }
  for (const SceneSummary& scene : server.summary()) {
    EXPECT_EQ(scene.counters.samples.samples, 100u) << scene.scene;
    for (const std::uint64_t drops : scene.counters.drops) EXPECT_EQ(drops, 0u) << scene.scene;
  }
}

TEST(Loopback, TwoClientsShareAScene) {
  Server server(any_port(), two_scenes(), test::security());
  ControlClient control(server.control_port());
  const test::JoinedBy first = control.join(test::join_request());
  DatagramClient a(first);
  DatagramClient b(control.join(test::join_request()));
  EXPECT_NE(a.joined.session, b.joined.session);
  EXPECT_EQ(a.joined.port_offset, 1u);
  EXPECT_EQ(first.udp_port, server.scenes()[0].udp_port);
  EXPECT_EQ(a.joined.silence_timeout, 2.0);
  EXPECT_TRUE(a.joined.friction);
  EXPECT_EQ(a.joined.start_position, Vec3(0.01, 0, 0));
  EXPECT_EQ(a.joined.start_normal, Vec3(0, 0, 1));
  EXPECT_EQ(a.joined.stiffness, 2000.0);

  // Each session must get the answers of a session that is alone.
  const Scene scene = test::room();
  Session alone(test::join_request(), scene);
  for (std::uint64_t n = 1; n <= 300; ++n) {
    const Reply felt = a.exchange(test::hand_batch(n, 3));
    const Reply expected = alone.take(test::hand_batch(n, 3), Nanoseconds(0)).reply;
    ASSERT_EQ(felt.sample_index, n);
    ASSERT_EQ(felt.command.elastic, expected.command.elastic);
    ASSERT_EQ(felt.command.frictional, expected.command.frictional);
    ASSERT_GT(felt.server_times.received.count(), 0);
    ASSERT_EQ(b.exchange(test::hand_batch(1000 + n)).sample_index, 1000 + n);
  }
  const auto list = control.ask<control::SceneList>(control::ListScenes{});
  ASSERT_EQ(list.scenes.size(), 2u);
  EXPECT_EQ(list.scenes[0].name, "room");
  EXPECT_EQ(list.scenes[0].port_offset, 1u);
  EXPECT_EQ(list.scenes[1].port_offset, 1u);
  EXPECT_EQ(list.scenes[0].objects, 2u);
  EXPECT_EQ(list.scenes[0].sessions, 2u);
  EXPECT_EQ(list.scenes[1].sessions, 0u);

  EXPECT_EQ(control.ask<control::Left>(control::LeaveRequest{b.joined.session}).session,
            b.joined.session);
  EXPECT_EQ(control.ask<control::SceneList>(control::ListScenes{}).scenes[0].sessions, 1u);

  server.stop();
  EXPECT_EQ(a.await_goodbye(), GoodbyeReason::shutting_down);
  const auto summary = server.summary();
  EXPECT_EQ(summary[0].counters.sessions_served, 2u);
  EXPECT_EQ(summary[0].counters.samples.samples, 600u);
  EXPECT_EQ(summary[0].counters.samples.replies, 600u);
  EXPECT_EQ(summary[0].unsent, 0u);
  EXPECT_THAT(text(summary), ::testing::HasSubstr("scene room: sessions 2"));
}

/// A timer of the scene's thread must step moving bodies, whether the thread sleeps or polls.
TEST(Loopback, WhatMovesIsSteppedWhileNoDatagramComes) {
  for (const double busy_poll : {0.0, std::numeric_limits<double>::infinity()}) {
    ServerConfig config = any_port();
    config.silence_timeout = 0.2;
    config.busy_poll = busy_poll;
    Server server(config,
                  {test::moving({test::object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                                {test::body("ball", 0.2)}, test::kWeightless)},
                  test::security());
    ControlClient control(server.control_port());
    control::JoinRequest request = test::join_request({});
    request.scene = "moving";
    DatagramClient client(control.join(request));
    SampleBatch batch = test::hand_batch(1);
    batch.samples[0].pose.position = {-0.029, 0, 0};
    EXPECT_NEAR(client.exchange(batch).command.elastic.x(), -1.0, 1e-9);
    EXPECT_EQ(client.await_goodbye(), GoodbyeReason::evicted);
    server.stop();
    // The server makes some 200 steps. The datagram alone would make a single step.
    EXPECT_GT(server.summary()[0].counters.world.steps, 20u);
    EXPECT_EQ(server.summary()[0].counters.world.resets, 0u);
    EXPECT_THAT(text(server.summary()), ::testing::HasSubstr("steps of what moves"));
  }
}

/// Returns the number of threads of this process with SCHED_FIFO.
std::size_t real_time_threads() {
  std::size_t count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
    count += ::sched_getscheduler(std::stoi(task.path().filename())) == SCHED_FIFO ? 1 : 0;
  return count;
}

TEST(Loopback, AScenesThreadIsScheduledBeforeOthersWhereItAsksAndMay) {
  bool permitted = false;
  std::thread([&] { permitted = request_real_time(kScenePriority).scheduler; }).join();
  const auto beside = [](bool asks, double busy_poll) {
    ServerConfig config = any_port();
    config.real_time = asks;
    config.busy_poll = busy_poll;
    Server server(config, two_scenes(), test::security());
    for (const char* scene : {"room", "ball"}) {
      control::JoinRequest request = test::join_request({});
      request.scene = scene;
      ControlClient control(server.control_port());
      DatagramClient client(control.join(request));
      client.exchange(test::hand_batch(1));  // The scene's thread runs.
    }
    return real_time_threads();
  };
  EXPECT_EQ(beside(false, 0.0), 0u);
  EXPECT_EQ(beside(true, 0.0), permitted ? 2u : 0u);
  // The kernel would stop a polling thread for 50 ms of every second.
  EXPECT_EQ(beside(true, HUGE_VAL), 0u);
}

/// A burst longer than a batch must get all its answers, in the order of the samples.
TEST(Loopback, BurstIsDrained) {
  Server server(any_port(), two_scenes(), test::security());
  ControlClient control(server.control_port());
  DatagramClient client(control.join(test::join_request()));
  constexpr std::uint64_t kBurst = 200;
  for (std::uint64_t n = 1; n <= kBurst; ++n)
    client.socket.send(client.encoder.samples(client.joined.session, n, test::hand_batch(n)));
  for (std::uint64_t n = 1; n <= kBurst; ++n) {
    const auto bytes = client.socket.receive();
    Reply reply;
    ASSERT_EQ(decode(client.opened(bytes), reply), DropReason::none);
    ASSERT_EQ(reply.sample_index, n);
  }
}

TEST(Loopback, RepliesFollowAClientThatMoves) {
  Server server(any_port(), two_scenes(), test::security());
  ControlClient control(server.control_port());
  const auto joined = control.join(test::join_request());
  DatagramClient before(joined), after(joined);
  EXPECT_EQ(before.exchange(test::hand_batch(1)).sample_index, 1u);
  after.packet = before.packet;
  EXPECT_EQ(after.exchange(test::hand_batch(2)).sample_index, 2u);
}

TEST(Loopback, SilenceEndsWithAGoodbye) {
  ServerConfig config = any_port();
  config.silence_timeout = 0.1;
  Server server(config, two_scenes(), test::security());
  ControlClient control(server.control_port());
  DatagramClient client(control.join(test::join_request()));
  client.exchange(test::hand_batch(1));
  EXPECT_EQ(client.await_goodbye(), GoodbyeReason::evicted);
}

TEST(Loopback, RefusalsSayWhy) {
  using control::Refused, control::RefusalCode;
  ServerConfig config = any_port();
  config.max_sessions_per_scene = 1;
  Server server(config, two_scenes(), test::security());
  ControlClient control(server.control_port());
  auto request = test::join_request();
  request.scene = "nowhere";
  const auto unknown = control.ask<Refused>(request);
  EXPECT_EQ(unknown.code, RefusalCode::unknown_scene);
  EXPECT_THAT(unknown.reason, ::testing::HasSubstr("nowhere"));
  request = test::join_request();
  request.device.max_force = -1;
  EXPECT_EQ(control.ask<Refused>(request).code, RefusalCode::bad_device);
  EXPECT_EQ(control.ask<Refused>(control::LeaveRequest{77}).code, RefusalCode::unknown_session);
  EXPECT_EQ(control.ask<Refused>(control::LeaveRequest{0x1ff}).code, RefusalCode::unknown_session);
  control.ask<control::JoinAccepted>(test::join_request());
  EXPECT_EQ(control.ask<Refused>(test::join_request()).code, RefusalCode::full);
}

TEST(Loopback, ParametersChangeWhileRunning) {
  Server server(any_port(), two_scenes(), test::security());
  ControlClient control(server.control_port());
  SessionParameters parameters = test::join_request().parameters;
  parameters.side = BoundingSide::server;
  DatagramClient client(control.join(test::join_request(parameters)));
  client.exchange(test::hand_batch(1));
  SampleBatch pressed = test::hand_batch(2);
  pressed.samples[0].pose.position = {-0.1, 0, -0.01};
  parameters.mode = "none";
  const auto set = control.ask<control::ParametersSet>(
      control::SetParameters{client.joined.session, parameters});
  EXPECT_EQ(set.parameters.mode, "none");
  // The hand moved in one step and gets the complete device force. Any bound would reduce this
  // force.
  const Reply unbounded = client.exchange(pressed);
  EXPECT_TRUE(unbounded.bound.saturated);
  EXPECT_NEAR(unbounded.command.force().norm(), test::device().max_force, 1e-6);
}

TEST(Loopback, HostileFramesAreRefusedAndClosed) {
  Server server(any_port(), two_scenes(), test::security());
  const std::vector<std::vector<std::uint8_t>> frames = {
      {0xff, 0xff, 0xff, 0xff},           // announces four gigabytes
      {0x00, 0x00, 0x00, 0x00},           // announces nothing
      {0x01, 0x00, 0x01, 0x00, 1, 2, 3},  // one byte above the limit
      {0x08, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8},
      control::encode(control::Left{1}),  // an answer instead of a request
  };
  for (const auto& frame : frames) {
    ControlClient client(server.control_port());
    client.send_raw(frame);
    const auto answer = client.receive();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(std::get<control::Refused>(*answer).code, control::RefusalCode::malformed);
    EXPECT_TRUE(client.closed());
  }
  ControlClient good(server.control_port());
  EXPECT_EQ(good.ask<control::SceneList>(control::ListScenes{}).scenes.size(), 2u);
}

TEST(Loopback, RequestsMayComeInPieces) {
  Server server(any_port(), two_scenes(), test::security());
  ControlClient client(server.control_port());
  for (const std::uint8_t byte : control::encode(control::ListScenes{}))
    client.send_raw({&byte, 1});
  ASSERT_TRUE(client.receive().has_value());
}

TEST(Loopback, StopEndsConnections) {
  Server server(any_port(), two_scenes(), test::security());
  ControlClient idle(server.control_port());
  idle.ask<control::SceneList>(control::ListScenes{});
  server.stop();
  server.stop();  // A second stop must do nothing.
  EXPECT_TRUE(idle.closed());
}

TEST(Loopback, PortInUseIsOneClearLine) {
  Server server(any_port(), two_scenes(), test::security());
  ServerConfig config = any_port();
  config.port = server.control_port();
  try {
    Server second(config, two_scenes(), test::security());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(std::to_string(server.control_port())));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("--port"));
    EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n")));
  }
}

TEST(Loopback, ScenesOfOneNameAreRefused) {
  std::vector<Scene> twins;
  twins.push_back(test::room());
  twins.push_back(test::room());
  EXPECT_THROW(Server(any_port(), std::move(twins), test::security()), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::loopback_test
