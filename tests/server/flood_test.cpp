// Honest clients while garbage comes as fast as a thread can send it: counts only, speed is
// feltwire-netbench's (docs/benchmarks.md).

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/server.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/garbage.hpp"

namespace feltwire {
namespace {

using test::ControlClient;
using test::RawSocket;

/// Sends until it is destroyed.
class Flood {
 public:
  Flood(std::uint16_t port, std::uint64_t known_session) : socket_(SOCK_DGRAM, port) {
    constexpr int kDatagrams = 256;
    test::Garbage garbage({known_session});
    for (int i = 0; i < kDatagrams; ++i) datagrams_.push_back(garbage.next());
    thread_ = std::thread([this] {
      while (!ended_.load(std::memory_order_relaxed))
        for (const auto& datagram : datagrams_) socket_.send(datagram);
    });
  }
  ~Flood() { end(); }
  void end() {
    ended_.store(true, std::memory_order_relaxed);
    if (thread_.joinable()) thread_.join();
  }
  /// Whether anything ever came back.
  bool answered() const {
    std::uint8_t byte = 0;
    return ::recv(socket_.descriptor(), &byte, 1, MSG_DONTWAIT) >= 0;
  }

 private:
  RawSocket socket_;
  std::vector<std::vector<std::uint8_t>> datagrams_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

/// One hand; what the flood crowds out of the server's socket is lost like any datagram.
struct Honest {
  std::uint64_t session;
  RawSocket socket;
  Encoder encoder;
  std::uint64_t sent = 0;
  int answered = 0, wrong = 0;

  explicit Honest(const control::JoinAccepted& joined)
      : session(joined.session), socket(SOCK_DGRAM, joined.udp_port) {}

  void send() {
    ++sent;
    socket.send(encoder.samples(session, sent, test::hand_batch(sent, 3)));
  }
  void receive() {
    std::array<std::uint8_t, kMaxDatagram> buffer;
    while (true) {
      const auto size = ::recv(socket.descriptor(), buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size < 0) return;
      const Guarded guarded =
          guard({buffer.data(), static_cast<std::size_t>(size)}, test::kAllKinds);
      Reply reply;
      const bool good = guarded.drop == DropReason::none && guarded.header.session == session &&
                        decode(guarded.payload, reply) == DropReason::none;
      ++(good ? answered : wrong);
    }
  }
};

TEST(Flood, HonestClientsAreAnsweredAndNobodyElse) {
  constexpr int kClients = 20, kAnswers = 50;
  constexpr std::uint64_t kMostSamples = 100'000;  // then the server has stopped answering
  ServerConfig config;
  config.port = 0;
  config.log_level = "off";
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  Server server(config, std::move(scenes));
  ControlClient control(server.control_port());
  const auto known = control.ask<control::JoinAccepted>(test::join_request());
  std::vector<std::unique_ptr<Honest>> clients;
  for (int i = 0; i < kClients; ++i)
    clients.push_back(
        std::make_unique<Honest>(control.ask<control::JoinAccepted>(test::join_request())));

  Flood flood(known.udp_port, known.session);
  for (bool waiting = true; waiting;) {
    waiting = false;
    for (auto& client : clients) {
      client->receive();
      if (client->answered >= kAnswers) continue;
      waiting = true;
      ASSERT_LT(client->sent, kMostSamples);
      client->send();
    }
    std::this_thread::yield();
  }
  flood.end();
  // Still there, and the control port answers.
  EXPECT_GE(control.ask<control::SceneList>(control::ListScenes{}).scenes[0].sessions,
            static_cast<std::uint32_t>(kClients));
  server.stop();
  EXPECT_FALSE(flood.answered());

  const SceneCounters counters = server.summary()[0].counters;
  const auto dropped = [&](DropReason reason) {
    return counters.drops[static_cast<std::size_t>(reason)];
  };
  for (const DropReason reason :
       {DropReason::size, DropReason::magic, DropReason::session, DropReason::malformed})
    EXPECT_GT(dropped(reason), 0u) << name(reason);
  std::uint64_t all = counters.samples.replies;
  for (const std::uint64_t count : counters.drops) all += count;
  EXPECT_EQ(counters.datagrams, all);
  EXPECT_EQ(counters.left, 0u);
  for (const auto& client : clients) EXPECT_EQ(client->wrong, 0);
}

}  // namespace
}  // namespace feltwire
