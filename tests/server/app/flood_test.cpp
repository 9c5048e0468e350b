// Tests honest clients during a flood of invalid datagrams. The test only counts. feltwire-netbench
// measures the speed (docs/lab/benchmarks.md).

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/app/server.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/garbage.hpp"

namespace feltwire::flood_test {
namespace {

using test::ControlClient;
using test::RawSocket;

/// Sends until the destructor runs.
class Flood {
 public:
  Flood(std::uint16_t port, const std::vector<std::uint64_t>& known) : socket_(SOCK_DGRAM, port) {
    constexpr int kDatagrams = 256;
    test::Garbage garbage(known);
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
  /// Returns true if the flood ever got an answer.
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

/// An honest hand. The flood may displace the hand's datagrams in the server's socket.
struct Honest {
  std::uint64_t session;
  RawSocket socket;
  SessionKeys keys;
  test::SealedEncoder encoder;
  std::uint64_t sent = 0;
  int answered = 0, wrong = 0;

  explicit Honest(const test::JoinedBy& joined)
      : session(joined.accepted.session),
        socket(SOCK_DGRAM, joined.udp_port),
        keys(joined.keys),
        encoder(test::Way::up, joined.keys) {}

  void send() {
    ++sent;
    socket.send(encoder.samples(session, sent, test::hand_batch(sent, 3)));
  }
  void receive() {
    std::array<std::uint8_t, kMaxDatagram> buffer;
    while (true) {
      const auto size = ::recv(socket.descriptor(), buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size < 0) return;
      const Bytes bytes{buffer.data(), static_cast<std::size_t>(size)};
      Reply reply;
      const bool good =
          guard(bytes, test::kAllKinds).header.session == session &&
          decode(test::opened(bytes, test::Way::down, keys), reply) == DropReason::none;
      ++(good ? answered : wrong);
    }
  }
};

TEST(Flood, HonestClientsAreAnsweredAndNobodyElse) {
  constexpr int kClients = 20, kAnswers = 50;
  // More samples mean that the server stopped answering.
  constexpr std::uint64_t kMostSamples = 100'000;
  ServerConfig config = test::any_port();
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  config.sample_rate_limit = 1e3;  // no rate limit in this test
  config.max_sessions_per_client = kClients;
  Server server(config, std::move(scenes), test::security());
  ControlClient control(server.control_port());
  std::vector<std::uint64_t> overheard;
  std::vector<std::unique_ptr<Honest>> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.push_back(std::make_unique<Honest>(control.join(test::join_request())));
    overheard.push_back(clients.back()->session);
  }

  Flood flood(server.scenes().front().udp_port, overheard);
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
  // The sessions must still exist, and the control port must answer.
  EXPECT_GE(control.ask<control::SceneList>(control::ListScenes{}).scenes[0].sessions,
            static_cast<std::uint32_t>(kClients));
  server.stop();
  EXPECT_FALSE(flood.answered());

  const SceneCounters counters = server.summary()[0].counters;
  const auto dropped = [&](DropReason reason) {
    return counters.drops[static_cast<std::size_t>(reason)];
  };
  for (const DropReason reason :
       {DropReason::size, DropReason::magic, DropReason::session, DropReason::sealed})
    EXPECT_GT(dropped(reason), 0u) << name(reason);
  std::uint64_t all = counters.samples.replies;
  for (const std::uint64_t count : counters.drops) all += count;
  EXPECT_EQ(counters.datagrams, all);
  EXPECT_EQ(counters.left, 0u);
  for (const auto& client : clients) EXPECT_EQ(client->wrong, 0);
}

}  // namespace
}  // namespace feltwire::flood_test
