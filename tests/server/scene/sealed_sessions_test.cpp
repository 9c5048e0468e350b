// Tests sessions under attack. Without a key nothing may change. A flooding session must be slowed
// and then ended. The clock is simulated.

#include <gtest/gtest.h>
#include <netinet/in.h>

#include "server/scene/sample_rate.hpp"
#include "server/scene/scene_sessions.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::sealed_sessions_test {
namespace {

using namespace std::chrono_literals;
using test::hand_batch;
using test::join_request;
using test::Way;
using Octets = std::vector<std::uint8_t>;

constexpr std::uint64_t kId = 0x1234567800, kOther = kId + 256;

Octets octets(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

Peer peer_at(std::uint16_t port) {
  Peer peer{.address = {}, .length = sizeof(sockaddr_in)};
  reinterpret_cast<sockaddr_in&>(peer.address).sin_port = port;
  return peer;
}
std::uint16_t port_of(const Peer& peer) {
  return reinterpret_cast<const sockaddr_in&>(peer.address).sin_port;
}

struct World {
  Scene scene = test::room();
  SceneSessions sessions;
  DatagramBuffer out;
  Peer peer = peer_at(1);
  test::SealedEncoder client{Way::up};

  explicit World(const SessionLimits& limits = {}) : sessions(scene, 2s, 4, nullptr, limits) {}
  void join(std::uint64_t id, const SessionKeys& keys, Nanoseconds now = 0s) {
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions.answer(join_request(), id, keys, now)));
  }
  void join(std::uint64_t id) { join(id, test::keys(id)); }
  /// Returns the size of the answer.
  std::size_t receive(Bytes datagram, Nanoseconds now = 0s) {
    return sessions.receive(datagram, peer, now, out).size();
  }
  std::size_t send(std::uint64_t n, Nanoseconds now = 0s, std::uint64_t id = kId) {
    return receive(client.samples(id, n, hand_batch(n)), now);
  }
  std::uint64_t drops(DropReason reason) const {
    return sessions.counters().drops[static_cast<std::size_t>(reason)];
  }
};

class SealedSessions : public ::testing::TestWithParam<CipherSuite> {};
INSTANTIATE_TEST_SUITE_P(Suites, SealedSessions, ::testing::ValuesIn(test::suites()));

/// Tests a complete exchange with each cipher suite, independent of the machine's preference.
TEST_P(SealedSessions, BothEndsUnderstandEachOther) {
  World world;
  const SessionKeys keys = test::keys(kId, GetParam());
  world.join(kId, keys);
  test::SealedEncoder client(Way::up, keys);
  for (std::uint64_t n = 1; n <= 20; ++n) {
    const Bytes answer =
        world.sessions.receive(client.samples(kId, n, hand_batch(n)), world.peer, 0s, world.out);
    Reply reply;
    ASSERT_EQ(decode(test::opened(answer, Way::down, keys), reply), DropReason::none);
    ASSERT_EQ(reply.sample_index, n);
  }
}

TEST_P(SealedSessions, EveryBitFlipAndEveryCutIsDroppedAndChangesNothing) {
  World attacked, alone;
  const SessionKeys keys = test::keys(kId, GetParam());
  attacked.join(kId, keys);
  alone.join(kId, keys);
  test::SealedEncoder client(Way::up, keys);
  for (std::uint64_t n = 1; n <= 3; ++n) {
    const Octets sent = octets(client.samples(kId, n, hand_batch(n)));
    for (std::size_t bit = 0; bit < 8 * sent.size(); ++bit) {
      Octets spoiled = sent;
      spoiled[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
      ASSERT_EQ(attacked.receive(spoiled), 0u) << bit;
    }
    for (std::size_t size = 0; size < sent.size(); ++size)
      ASSERT_EQ(attacked.receive(Bytes(sent).first(size)), 0u) << size;
    const std::size_t size = attacked.receive(sent);
    ASSERT_EQ(size, alone.receive(sent));
    ASSERT_GT(size, 0u);
    ASSERT_TRUE(std::equal(attacked.out.bytes.begin(),
                           attacked.out.bytes.begin() + static_cast<long>(size),
                           alone.out.bytes.begin()));
  }
  EXPECT_GT(attacked.drops(DropReason::sealed), 3000u);
  EXPECT_EQ(attacked.sessions.counters().samples.replies, 3u);
}

TEST_P(SealedSessions, NothingOfOneSessionIsOfUseInAnother) {
  World world;
  world.join(kId, test::keys(kId, GetParam()));
  world.join(kOther, test::keys(kOther, GetParam()));
  test::SealedEncoder client(Way::up, test::keys(kId, GetParam()));
  Octets datagram = octets(client.samples(kId, 1, hand_batch(1)));
  write_header(datagram, {DatagramKind::samples, kOther, 1});
  EXPECT_EQ(world.receive(datagram), 0u);
  // The server must also drop its own reflected datagrams.
  const std::size_t size = world.receive(client.samples(kId, 1, hand_batch(1)));
  Octets reflected = octets(Bytes(world.out.bytes).first(size));
  EXPECT_EQ(world.receive(reflected), 0u);
  EXPECT_EQ(world.drops(DropReason::kind), 1u);
  write_header(reflected, {DatagramKind::samples, kId, 2});
  EXPECT_EQ(world.receive(reflected), 0u);
  EXPECT_EQ(world.drops(DropReason::sealed), 2u);
}

TEST(SealedSession, NobodyElseSaysGoodbyeForIt) {
  World world;
  world.join(kId);
  world.send(1);
  test::SealedEncoder stranger(Way::up, test::keys(99));
  EXPECT_EQ(world.receive(stranger.goodbye(kId, 2, GoodbyeReason::leaving)), 0u);
  EXPECT_EQ(world.drops(DropReason::sealed), 1u);
  EXPECT_EQ(world.sessions.size(), 1u);
  EXPECT_GT(world.send(2), 0u);  // The number is still unused.
  world.receive(world.client.goodbye(kId, 3, GoodbyeReason::leaving));
  EXPECT_EQ(world.sessions.size(), 0u);
}

TEST(SealedSession, ANewSessionHearsNothingOfTheOld) {
  World world;
  world.join(kId);
  const Octets old = octets(world.client.samples(kId, 5, hand_batch(5)));
  world.receive(world.client.goodbye(kId, 1, GoodbyeReason::leaving));
  world.join(kId, test::keys(kId + 1));  // The id is equal by chance, but keys are never equal.
  EXPECT_EQ(world.receive(old), 0u);
  EXPECT_EQ(world.drops(DropReason::sealed), 1u);
}

/// The goodbye must go to the right address. The lambda returns the number of this address.
TEST(SealedSession, ItsAddressMovesWithTheNewestDatagramThatIsItsOwn) {
  const auto address_after = [](auto act) {
    World world;
    world.join(kId);
    world.send(1);
    act(world);
    return port_of(world.sessions.shut_down().at(0).to);
  };
  EXPECT_EQ(address_after([](World&) {}), 1);
  EXPECT_EQ(address_after([](World& w) { w.peer = peer_at(2), w.send(2); }), 2);
  EXPECT_EQ(address_after([](World& w) {  // forged
              Octets forged = octets(w.client.samples(kId, 2, hand_batch(2)));
              forged.back() ^= 1;
              w.peer = peer_at(2);
              w.receive(forged);
            }),
            1);
  EXPECT_EQ(address_after([](World& w) {  // replayed
              w.peer = peer_at(2);
              w.send(1);
            }),
            1);
  EXPECT_EQ(address_after([](World& w) {  // delayed and sent from another address
              w.send(3);
              w.peer = peer_at(2);
              w.send(2);
            }),
            1);
  EXPECT_EQ(address_after([](World& w) {  // a newer sample with an older number
              w.send(3);
              w.peer = peer_at(2);
              w.receive(w.client.samples(kId, 2, hand_batch(9)));
            }),
            1);
}

TEST(SealedSession, TooManyForgeriesEndIt) {
  World world({.forgeries = 100});
  world.join(kId);
  world.send(1);
  Octets forged = octets(world.client.samples(kId, 2, hand_batch(2)));
  forged.back() ^= 1;
  for (int i = 0; i < 99; ++i) world.receive(forged);
  EXPECT_TRUE(world.sessions.expire(0s).empty());
  EXPECT_GT(world.send(2), 0u);
  forged[16] = 3;  // a new packet number
  world.peer = peer_at(7);
  world.receive(forged);
  EXPECT_EQ(world.send(3), 0u);
  const auto goodbyes = world.sessions.expire(0s);
  ASSERT_EQ(goodbyes.size(), 1u);
  EXPECT_EQ(port_of(goodbyes[0].to), 1);
  GoodbyeReason reason = GoodbyeReason::leaving;
  ASSERT_EQ(decode(test::opened(goodbyes[0].datagram, Way::down), reason), DropReason::none);
  EXPECT_EQ(reason, GoodbyeReason::evicted);
  EXPECT_EQ(world.sessions.counters().forged, 1u);
}

// Tests of the allowed sample rate of a session.

/// The counts of a session that sends at `rate` [1/s] for `time` [s].
struct Sent {
  std::uint64_t answered = 0, slowed = 0;
  double flooding_after = -1.0;  // [s] -1: no flood
};
Sent send_at(double rate, double time) {
  World world;
  world.join(kId);
  Sent sent;
  const auto count = static_cast<std::uint64_t>(rate * time);
  for (std::uint64_t n = 1; n <= count; ++n) {
    const Nanoseconds now = 5s + from_seconds(static_cast<double>(n) / rate);
    sent.answered += world.send(n, now) > 0 ? 1 : 0;
    const auto goodbyes = world.sessions.expire(now);
    if (goodbyes.empty()) continue;
    GoodbyeReason reason = GoodbyeReason::leaving;
    EXPECT_EQ(decode(test::opened(goodbyes[0].datagram, Way::down), reason), DropReason::none);
    EXPECT_EQ(reason, GoodbyeReason::flooding);
    EXPECT_EQ(world.sessions.counters().flooded, 1u);
    sent.flooding_after = static_cast<double>(n) / rate;
    break;
  }
  sent.slowed = world.drops(DropReason::rate);
  return sent;
}

TEST(SampleRate, WhoKeepsToItIsNeverSlowed) {
  for (const double rate : {500.0, 1000.0, 1400.0}) {
    const Sent sent = send_at(rate, 10.0);
    EXPECT_EQ(sent.answered, static_cast<std::uint64_t>(10.0 * rate));
    EXPECT_EQ(sent.slowed, 0u);
    EXPECT_LT(sent.flooding_after, 0.0);
  }
}

TEST(SampleRate, WhoDoesNotIsSlowed) {
  const Sent sent = send_at(2900.0, 10.0);
  EXPECT_LT(sent.flooding_after, 0.0);
  EXPECT_NEAR(static_cast<double>(sent.answered), 1500.0 * 10.0 + 1500.0, 5.0);
  EXPECT_EQ(sent.answered + sent.slowed, 29'000u);
}

TEST(SampleRate, WhoFloodsIsEnded) {
  EXPECT_NEAR(send_at(6000.0, 10.0).flooding_after, 1.0, 0.01);
  EXPECT_NEAR(send_at(4500.0, 10.0).flooding_after, 2.0, 0.01);
  EXPECT_NEAR(send_at(100'000.0, 10.0).flooding_after, 3000.0 / 97'000.0, 0.001);
}

/// A network delays datagrams for a second and releases them at once. The server must drop none.
TEST(SampleRate, WhatANetworkHeldBackIsTaken) {
  World world;
  world.join(kId);
  std::uint64_t n = 0;
  for (int second = 0; second < 10; ++second)
    for (int i = 0; i < 1000; ++i) EXPECT_GT(world.send(++n, 1s * second), 0u);
  EXPECT_EQ(world.drops(DropReason::rate), 0u);
  EXPECT_TRUE(world.sessions.expire(9s).empty());
}

/// A datagram with nine new samples must count nine times. Nine known samples must count once.
TEST(SampleRate, SamplesAreCountedNotDatagrams) {
  const auto answered = [](std::uint64_t fresh) {
    World world;
    world.join(kId);
    std::uint64_t answers = 0, index = 9;
    for (std::uint64_t n = 1; n <= 1000; ++n, index += fresh)
      answers += world.receive(world.client.samples(kId, n, hand_batch(index, kMaxRedundancy))) > 0
                     ? 1
                     : 0;
    return answers;
  };
  EXPECT_EQ(answered(1), 1000u);
  EXPECT_NEAR(static_cast<double>(answered(9)), 1500.0 / 9.0, 1.0);
}

TEST(SampleRate, AClockThatRunsBackGivesNothingAway) {
  TokenBucket bucket(10.0, 10.0);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(bucket.take(100s));
  EXPECT_FALSE(bucket.take(100s));
  EXPECT_FALSE(bucket.take(50s));
  EXPECT_FALSE(bucket.take(50s + 99ms));
  EXPECT_TRUE(bucket.take(50s + 201ms));
}

/// Only the owner of the key may cause a rate limit or an end of the session.
TEST(SampleRate, ForgeriesCountForNothing) {
  World world;
  world.join(kId);
  Octets forged = octets(world.client.samples(kId, 2, hand_batch(2)));
  forged.back() ^= 1;
  const Octets first = octets(world.client.samples(kId, 1, hand_batch(1)));
  world.receive(first);
  for (int i = 0; i < 20'000; ++i) {
    world.receive(forged);
    world.receive(first);
  }
  EXPECT_TRUE(world.sessions.expire(0s).empty());
  EXPECT_GT(world.send(2), 0u);
}

TEST(SealedSession, WhatIsDroppedAllocatesNothing) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers own the allocator";
#endif
  World world;
  world.join(kId);
  const Octets good = octets(world.client.samples(kId, 1, hand_batch(1)));
  Octets forged = good, foreign = good;
  forged.back() ^= 1;
  forged[16] = 9;
  write_header(foreign, {DatagramKind::samples, kOther, 1});
  world.receive(good);
  const std::size_t before = test::allocations();
  for (int i = 0; i < 2000; ++i) {
    world.receive(good);     // replayed
    world.receive(forged);   // not sealed
    world.receive(foreign);  // unknown session
    world.receive(Bytes(good).first(kMinDatagram - 1));
  }
  for (std::uint64_t n = 2; n <= 4000; ++n) world.send(n);  // above the rate
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(world.drops(DropReason::packet_number), 2000u);
  EXPECT_EQ(world.drops(DropReason::sealed), 2000u);
  EXPECT_EQ(world.drops(DropReason::session), 2000u);
  EXPECT_EQ(world.drops(DropReason::size), 2000u);
  EXPECT_EQ(world.drops(DropReason::rate), 2500u);
}

}  // namespace
}  // namespace feltwire::sealed_sessions_test
