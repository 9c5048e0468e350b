// Runs a complete server and two clients in one process, over real sockets of this machine.

#include "tests/client/loopback.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <array>
#include <atomic>

#include "client/transport/reconnector.hpp"
#include "tests/client/peer.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::loopback_test {
namespace {

using testing::Client;
using testing::kPatience;
using testing::kStroke;
using testing::Loopback;

TEST_F(Loopback, ListsItsScene) {
  const auto scenes = list_scenes(endpoint, kPatience);
  ASSERT_EQ(scenes.size(), 1u);
  EXPECT_EQ(scenes[0].name, "floor");
  EXPECT_EQ(scenes[0].objects, 1u);
}

TEST_F(Loopback, AnUnknownSceneIsRefusedByName) {
  try {
    Client lost(endpoint, kStroke, {}, "cellar");
    FAIL() << "joined a scene that is not there";
  } catch (const SessionError& error) {
    EXPECT_NE(std::string(error.what()).find("cellar"), std::string::npos) << error.what();
  }
}

TEST_F(Loopback, TwoHandsFeelTheFloorAtOnce) {
  Client bounded(endpoint, kStroke, {}, "floor");
  SessionParameters bare;
  bare.mode = "none";
  Client unbounded(endpoint, kStroke, bare, "floor");
  EXPECT_NE(bounded.joined.accepted.session, unbounded.joined.accepted.session);
  bounded.start();
  unbounded.start();
  bounded.finish();
  unbounded.finish();

  for (Client* client : {&bounded, &unbounded}) {
    const ServoStatistics& s = client->servo.statistics();
    EXPECT_EQ(client->result->end, EndReason::device_ended);
    EXPECT_GT(s.replies.answered, 0u);
    EXPECT_LE(s.replies.answered, s.samples);
    EXPECT_EQ(s.replies.refused, 0u);
    EXPECT_EQ(client->transport.statistics().dropped, TransportStatistics{}.dropped);
    // The force must be a force of the plane. The normal force is at most k times the depth, and
    // the friction is inside the friction cone.
    TickRecord row;
    double pressed = 0.0;
    while (client->records.pop(row)) {
      EXPECT_GE(row.elastic.z(), 0.0);
      EXPECT_LE(row.elastic.z(), 500.0 * 0.004 + 1e-9);
      EXPECT_EQ(row.elastic.head<2>().norm(), 0.0);
      EXPECT_LE(row.frictional.norm(), 0.4 * row.elastic.z() + 1e-9);
      pressed = std::max(pressed, row.elastic.z());
    }
    EXPECT_GT(pressed, 0.0);
    EXPECT_EQ(client->servo.held().force(), Vec3::Zero());
  }
  EXPECT_EQ(bounded.servo.port().violations(), 0u);

  // Wait for the clients' goodbyes, because a server that stops first would end the sessions
  // itself.
  test::eventually("the end of the sessions",
                   [&] { return list_scenes(endpoint, kPatience).at(0).sessions == 0; });
  server->stop();
  const auto summary = server->summary();
  ASSERT_EQ(summary.size(), 1u);
  EXPECT_EQ(summary[0].counters.sessions_served, 2u);
  EXPECT_EQ(summary[0].counters.left, 2u);  // The sessions must end by goodbye.
  EXPECT_EQ(summary[0].counters.silent, 0u);
}

TEST_F(Loopback, AServerThatStopsSaysGoodbye) {
  const char* const endless = "t,x,y,z\n0,0,0,-0.001\n1000,0,0,-0.001\n";
  Client client(endpoint, endless, {}, "floor");
  client.start();
  // The client needs an answer before the server stops. A record with the answer's age shows that
  // an answer arrived.
  client.next_tick("an answer", [](const TickRecord& row) { return row.age >= 0.0; });
  server->stop();
  client.finish();
  EXPECT_EQ(client.result->end, EndReason::server_goodbye);
  EXPECT_EQ(client.result->goodbye, GoodbyeReason::shutting_down);
  EXPECT_EQ(client.servo.held().force(), Vec3::Zero());
}

/// Returns strokes that enter the surface from outside repeatedly.
std::string strokes() {
  std::string rows = "t,x,y,z\n";
  for (int n = 0; n < 4000; ++n)
    rows += std::to_string(0.1 * n) + ",0,0," + (n % 2 == 0 ? "0.004\n" : "-0.004\n");
  return rows;
}

/// A network address translator between a client and a scene. On request it drops its mapping, and
/// the client's datagrams then come from another port.
class Translator {
 public:
  explicit Translator(std::uint16_t scene_port) : scene_port_(scene_port) {
    thread_ = std::thread([this] { run(); });
  }
  ~Translator() {
    done_.set();
    thread_.join();
  }
  Translator(const Translator&) = delete;
  Translator& operator=(const Translator&) = delete;

  const Address& address() const { return inside_.address(); }
  void forget() { wanted_.fetch_add(1); }
  /// Returns the number of datagrams that came back through this mapping.
  std::uint64_t answers(std::size_t mapping) const { return answers_.at(mapping).load(); }

 private:
  void run() {
    sockaddr_in scene{};
    scene.sin_family = AF_INET;
    scene.sin_port = htons(scene_port_);
    scene.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    Address client;
    std::array<std::uint8_t, kMaxDatagram> bytes;
    std::size_t mapping = 0;
    auto outside = std::make_unique<testing::LocalSocket>(SOCK_DGRAM);
    while (true) {
      std::array<pollfd, 3> waiting{{{done_.descriptor(), POLLIN, 0},
                                     {inside_.descriptor(), POLLIN, 0},
                                     {outside->descriptor(), POLLIN, 0}}};
      ::poll(waiting.data(), waiting.size(), -1);
      if (waiting[0].revents != 0) return;
      if (wanted_.load() != mapping) {
        outside =
            // Datagrams in the network are lost.
            std::make_unique<testing::LocalSocket>(SOCK_DGRAM);
        ++mapping;
        continue;
      }
      if (waiting[1].revents != 0) {
        client.size = sizeof client.storage;
        const ssize_t size = ::recvfrom(inside_.descriptor(), bytes.data(), bytes.size(), 0,
                                        reinterpret_cast<sockaddr*>(&client.storage), &client.size);
        if (size > 0)
          ::sendto(outside->descriptor(), bytes.data(), static_cast<std::size_t>(size), 0,
                   reinterpret_cast<const sockaddr*>(&scene), sizeof scene);
      }
      if (waiting[2].revents != 0) {
        const ssize_t size = ::recv(outside->descriptor(), bytes.data(), bytes.size(), 0);
        if (size > 0 &&
            ::sendto(inside_.descriptor(), bytes.data(), static_cast<std::size_t>(size), 0,
                     reinterpret_cast<const sockaddr*>(&client.storage), client.size) > 0)
          answers_[mapping].fetch_add(1);
      }
    }
  }

  std::uint16_t scene_port_;
  testing::LocalSocket inside_{SOCK_DGRAM};
  Event done_;
  std::atomic<std::size_t> wanted_{0};
  std::array<std::atomic<std::uint64_t>, 4> answers_{};
  std::thread thread_;
};

// The client's address changes three times during the run. The session must continue, and the hand
// must get force through each address.
TEST_F(Loopback, AClientsAddressMayChange) {
  Translator translator(server->scenes()[0].udp_port);
  Client client(endpoint, strokes().c_str(), {}, "floor", nullptr, &translator.address());
  client.start();
  for (std::size_t mapping = 0; mapping < 4; ++mapping) {
    if (mapping > 0) translator.forget();
    client.next_tick("force by mapping " + std::to_string(mapping), [&](const TickRecord& row) {
      return translator.answers(mapping) >= 50 && row.held.z() > 0.0;
    });
  }
  client.stop.set();
  client.finish();
  EXPECT_EQ(client.result->end, EndReason::requested);
  EXPECT_EQ(client.result->disconnections, 0u);
  EXPECT_EQ(client.servo.port().violations(), 0u);
  server->stop();
  EXPECT_EQ(server->summary()[0].counters.sessions_served, 1u);
}

TEST(Ipv6, AHandFeelsOverIpv6) {
  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  ServerConfig config = testing::any_ports();
  config.address = "::1";
  std::unique_ptr<Server> server;
  try {
    server = std::make_unique<Server>(config, std::move(scenes), test::security());
  } catch (const std::runtime_error&) {
    GTEST_SKIP() << "this machine has no IPv6";
  }
  Client client(test::access(server->control_port(), "::1"), kStroke, {}, "floor");
  EXPECT_EQ(client.joined.datagrams.storage.ss_family, AF_INET6);
  client.start();
  client.finish();
  EXPECT_EQ(client.result->end, EndReason::device_ended);
  EXPECT_GT(client.servo.statistics().replies.answered, 0u);
  EXPECT_GT(client.servo.statistics().max_force, 0.0);
  EXPECT_EQ(client.servo.port().violations(), 0u);
}

// The server ends, and another server with another address replaces it. The hand must then get
// force again.
TEST_F(Loopback, AnotherServerTakesOver) {
  Client client(endpoint, strokes().c_str(), {}, "floor");
  Ring<SessionAddress> sessions(4);
  client.start({.silence_timeout = kPatience, .patience = kPatience, .rejoined = &sessions});
  const auto felt = [&] {
    client.next_tick("force", [](const TickRecord& row) { return row.held.z() > 0.0; });
  };
  felt();

  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  Server successor(testing::any_ports(), std::move(scenes), test::security());
  Reconnector reconnector(
      test::access(successor.control_port()),
      {"tester", "floor", client.device.spec(), client.joined.accepted.parameters}, sessions);
  server->stop();
  const double hold_time = client.servo.parameters().hold_time;
  const TickRecord faded = client.next_tick(
      "the end of the hold time", [&](const TickRecord& row) { return row.age >= hold_time; });
  EXPECT_EQ(faded.held, Vec3::Zero());
  TickRecord row = faded;
  test::eventually("force by the successor", [&] {
    reconnector.look(row.age < hold_time, Reconnector::Clock::now());
    return client.records.pop(row) && row.age < hold_time && row.held.z() > 0.0;
  });
  client.stop.set();
  client.finish();
  EXPECT_EQ(client.result->end, EndReason::requested);
  EXPECT_EQ(client.result->disconnections, 1u);
  EXPECT_EQ(client.result->reconnections, 1u);
  EXPECT_GT(client.result->disconnected, 0.0);
  EXPECT_EQ(client.servo.port().violations(), 0u);
}

TEST_F(Loopback, ALostSessionThatNobodyFindsEndsAfterItsPatience) {
  Client client(endpoint, "t,x,y,z\n0,0,0,-0.001\n1000,0,0,-0.001\n", {}, "floor");
  Ring<SessionAddress> sessions(4);
  client.start({.silence_timeout = kPatience,
                .patience = std::chrono::milliseconds(50),
                .rejoined = &sessions});
  client.next_tick("an answer", [](const TickRecord& row) { return row.age >= 0.0; });
  server->stop();
  client.finish();
  EXPECT_EQ(client.result->end, EndReason::server_goodbye);
  EXPECT_EQ(client.result->disconnections, 1u);
  EXPECT_EQ(client.result->reconnections, 0u);
  EXPECT_GE(client.result->disconnected, 0.05);
}

}  // namespace
}  // namespace feltwire::loopback_test
