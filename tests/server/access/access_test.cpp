// Tests the control port's limits of connections and rates, for networks, strangers and known
// clients.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <deque>
#include <random>
#include <set>
#include <thread>

#include "server/access/connection_slots.hpp"
#include "server/access/rate_limit.hpp"
#include "server/access/wrong_tokens.hpp"
#include "tests/server/endpoint.hpp"

namespace feltwire::access_test {
namespace {

using namespace std::chrono_literals;
using test::ControlClient;
using test::Endpoint;
using test::RawSocket;
using test::served;

Network of(const std::string& address) { return network_of(asio::ip::make_address(address)); }

TEST(NetworkOf, AnAddressIsWhatWhoeverHasItHas) {
  EXPECT_EQ(of("2001:db8:1:2::1"), of("2001:db8:1:ffff:ffff:ffff:ffff:ffff"));
  EXPECT_NE(of("2001:db8:1:2::1"), of("2001:db8:2:2::1"));
  EXPECT_EQ(of("192.0.2.1"), of("192.0.2.255"));
  EXPECT_NE(of("192.0.2.1"), of("192.0.3.1"));
  EXPECT_EQ(of("::ffff:192.0.2.1"), of("192.0.2.77"));  // IPv4 in the form of an IPv6 socket
  EXPECT_NE(of("::"), of("0.0.0.0"));
  EXPECT_NE(of("::1"), of("127.0.0.1"));
}

HostAddress host(const std::string& address) { return host_of(asio::ip::make_address(address)); }

TEST(NetworkOf, AHostIsAPartOfIt) {
  EXPECT_EQ(host("2001:db8:1:2::1"), host("2001:db8:1:2:ffff:ffff:ffff:ffff"));
  EXPECT_NE(host("2001:db8:1:2::1"), host("2001:db8:1:3::1"));
  EXPECT_EQ(host("192.0.2.1"), host("::ffff:192.0.2.1"));
  EXPECT_NE(host("192.0.2.1"), host("192.0.2.2"));
}

/// A member that takes many slots must lose only its own slots.
TEST(ConnectionSlots, OneMemberTakesPlacesFromItself) {
  ConnectionSlots places(100, 8);
  const Network net = of("192.0.2.1");
  ConnectionSlots::Id next = 0;
  const ConnectionSlots::Id honest = next++;
  EXPECT_FALSE(places.take(honest, net, "honest"));
  for (int i = 0; i < 7; ++i) EXPECT_FALSE(places.take(next++, net, "busy"));
  for (int i = 0; i < 100; ++i) {
    const auto loser = places.take(next, net, "busy");
    ASSERT_EQ(loser, next - 7);  // the member's own oldest slot
    ++next;
  }
  EXPECT_EQ(places.take(next, net, "new"), next - 7);  // A new member must get a slot.
  EXPECT_TRUE(places.leave(honest));
}

/// A client that connects from many networks must lose only its own slots.
TEST(ConnectionSlots, AMemberHasALimitInAllNetworksTogether) {
  ConnectionSlots places(100, 50, 4);
  ConnectionSlots::Id next = 0;
  const ConnectionSlots::Id honest = next++;
  EXPECT_FALSE(places.take(honest, of("10.0.0.1"), "honest"));
  for (int i = 0; i < 200; ++i) {
    const auto loser = places.take(next, of("10.0." + std::to_string(i % 60) + ".1"), "busy");
    // the member's own oldest slot
    ASSERT_EQ(loser, i < 4 ? std::nullopt : std::optional(next - 4));
    ++next;
  }
  EXPECT_EQ(places.size(), 5u);
  EXPECT_TRUE(places.leave(honest));
}

TEST(WrongTokens, OneHostLeavesTheOthersTheirs) {
  WrongTokens wrong(2.0, 20.0);
  const auto at = [](const char* text) { return asio::ip::make_address(text); };
  int taken = 0;
  for (int i = 0; i < 1000; ++i) taken += wrong.take(at("192.0.2.1"), 1s) ? 1 : 0;
  EXPECT_EQ(taken, 10);
  EXPECT_TRUE(wrong.take(at("192.0.2.2"), 1s));
  for (int i = 3; i < 250; ++i) wrong.take(at(("192.0.2." + std::to_string(i)).c_str()), 1s);
  // The network of this address has reached its limit.
  EXPECT_FALSE(wrong.take(at("192.0.2.251"), 1s));
  EXPECT_TRUE(wrong.take(at("192.0.3.1"), 1s));
  EXPECT_TRUE(wrong.take(at("192.0.2.1"), 2s));
}

/// An attack from the security review: an IPv6 network with any number of addresses.
TEST(ConnectionSlots, ANetworkOfManyAddressesTakesPlacesFromItself) {
  ConnectionSlots places(256, 64);
  ConnectionSlots::Id next = 0;
  const ConnectionSlots::Id honest = next++;
  EXPECT_FALSE(places.take(honest, of("2001:db8::1")));
  std::deque<ConnectionSlots::Id> held;
  for (unsigned host = 0; host < 10'000; ++host) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "2001:db8:bad:1::%x", host);
    const auto loser = places.take(next, of(text.data()));
    held.push_back(next++);
    if (held.size() <= 64) {
      EXPECT_FALSE(loser);
      continue;
    }
    ASSERT_EQ(loser, held.front());  // the network's own oldest slot
    held.pop_front();
  }
  EXPECT_EQ(places.size(), 65u);
  EXPECT_TRUE(places.leave(honest));
}

/// Five networks together take all slots. A new client must get a slot and keep it while the five
/// continue.
TEST(ConnectionSlots, TheLargestNetworkGivesWay) {
  ConnectionSlots places(256, 64);
  ConnectionSlots::Id next = 0;
  const auto attack = [&](int rounds) {
    std::set<ConnectionSlots::Id> losers;
    for (int i = 0; i < rounds; ++i)
      for (int net = 0; net < 5; ++net)
        if (const auto loser = places.take(next++, of("10.0." + std::to_string(net) + ".1")))
          losers.insert(*loser);
    return losers;
  };
  attack(100);
  EXPECT_EQ(places.size(), 256u);
  const ConnectionSlots::Id honest = next++;
  ASSERT_TRUE(places.take(honest, of("192.0.2.7")));
  EXPECT_EQ(attack(1000).count(honest), 0u);
  EXPECT_EQ(places.size(of("192.0.2.1")), 1u);
  EXPECT_TRUE(places.leave(honest));
  EXPECT_FALSE(places.leave(honest));
}

TEST(ConnectionSlots, WhoIsRenewedGoesLast) {
  ConnectionSlots places(2, 2);
  EXPECT_FALSE(places.take(1, of("10.0.0.1")));
  EXPECT_FALSE(places.take(2, of("10.0.0.1")));
  places.renew(1);
  places.renew(77);  // 77 has no slot.
  EXPECT_EQ(places.take(3, of("10.0.0.1")), 2u);
  EXPECT_EQ(places.take(4, of("10.0.0.2")), 1u);
}

/// Compares random operations with a list of the holders. The number of holders must not exceed the
/// limits, in total and per network. Only a network with the most slots may lose a slot.
TEST(ConnectionSlots, HoldAtRandom) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (int round = 0; round < 20; ++round) {
    const std::size_t most = 1 + random() % 12, each = 1 + random() % 6;
    ConnectionSlots places(most, each);
    std::vector<std::pair<ConnectionSlots::Id, Network>> there;  // oldest first
    const auto count = [&](const Network& n) {
      return static_cast<std::size_t>(
          std::count_if(there.begin(), there.end(), [&](auto& e) { return e.second == n; }));
    };
    for (ConnectionSlots::Id id = 0; id < 300; ++id) {
      if (!there.empty() && random() % 4 == 0) {
        const std::size_t gone = random() % there.size();
        EXPECT_TRUE(places.leave(there[gone].first));
        there.erase(there.begin() + static_cast<std::ptrdiff_t>(gone));
      }
      const Network network = of("10.0." + std::to_string(random() % 5) + ".1");
      const bool full = there.size() == most, own_full = count(network) == each;
      const auto loser = places.take(id, network);
      ASSERT_EQ(loser.has_value(), full || own_full);
      there.emplace_back(id, network);
      if (loser) {
        const auto lost =
            std::find_if(there.begin(), there.end(), [&](auto& e) { return e.first == *loser; });
        ASSERT_NE(lost, there.end());
        const Network theirs = lost->second;
        ASSERT_NE(*loser, id);
        if (own_full) {
          ASSERT_EQ(theirs, network);
        } else {
          for (const auto& [other, net] : there) {
            if (other == id && count(net) == 1) continue;  // This network has no other member.
            ASSERT_LE(count(net), count(theirs));
          }
        }
        for (auto earlier = there.begin(); earlier != lost; ++earlier)
          ASSERT_NE(earlier->second, theirs);  // The loser is the oldest of its network.
        there.erase(lost);
      }
      ASSERT_EQ(places.size(), there.size());
      ASSERT_LE(places.size(), most);
      ASSERT_LE(places.size(network), each);
      ASSERT_EQ(places.size(network), count(network));
    }
  }
}

TEST(RateLimit, IsABucketForEachNetwork) {
  const Network a = of("10.0.0.1"), b = of("10.0.1.1");
  RateLimit<Network> rate(2.0, 3.0);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(rate.take(a, 0s));
  EXPECT_FALSE(rate.take(a, 499ms));
  EXPECT_FALSE(rate.take(of("::ffff:10.0.0.9"), 499ms));  // an address of the same network
  EXPECT_TRUE(rate.take(b, 499ms));
  EXPECT_TRUE(rate.take(a, 500ms));
  EXPECT_FALSE(rate.take(a, 501ms));
  EXPECT_TRUE(rate.take(a, 1h));
}

/// The burst must be complete at any rate, without rounding loss.
TEST(RateLimit, GivesTheWholeBurst) {
  for (const double rate : {0.1, 1.0 / 3.0, 1.0, 7.0, 49.0})
    for (const int burst : {1, 3, 7, 20, 49}) {
      RateLimit<int> limit(rate, burst);
      for (int i = 0; i < burst; ++i) EXPECT_TRUE(limit.take(0, 1s)) << rate << " " << burst;
      EXPECT_FALSE(limit.take(0, 1s)) << rate << " " << burst;
    }
}

/// Forged addresses of many networks must need limited memory.
TEST(RateLimit, IsNotOutnumbered) {
  RateLimit<std::uint32_t> rate(1.0, 1.0);
  for (std::uint32_t n = 0; n < RateLimit<std::uint32_t>::kMost; ++n) EXPECT_TRUE(rate.take(n, 0s));
  EXPECT_TRUE(rate.take(1'000'000, 0s));  // Beyond the limit, all such networks share a bucket.
  EXPECT_FALSE(rate.take(1'000'001, 0s));
  EXPECT_TRUE(rate.take(1'000'001, 2s));  // The other buckets are full again.
}

constexpr auto kNever = 1h;

ControlOptions patient(std::size_t connections, std::size_t of_a_network = 128) {
  return {.address = {},
          .handshake_timeout = kNever,
          .idle_timeout = kNever,
          .max_connections = connections,
          .max_connections_per_network = of_a_network,
          .handshake_rate = 1e6,
          .handshake_burst = 1e6};
}

/// An attack from the security review: four addresses with 64 silent connections each held all
/// slots during the complete handshake timeout.
TEST(Access, SilentStrangersKeepNobodyOut) {
  Endpoint endpoint(patient(16), control::SceneList{});
  ControlClient known(endpoint.port());
  std::vector<std::unique_ptr<RawSocket>> silent;
  for (int i = 0; i < 100; ++i) {
    const std::string from = "127.0." + std::to_string(1 + i % 5) + "." + std::to_string(1 + i);
    silent.push_back(
        std::make_unique<RawSocket>(SOCK_STREAM, endpoint.port(), AF_INET, from.c_str()));
  }
  EXPECT_TRUE(served(endpoint.port()));               // from another network
  EXPECT_TRUE(served(endpoint.port(), "127.0.1.1"));  // from an attacking network
  known.ask<control::SceneList>(control::ListScenes{});
  const ControlCounters counters = endpoint.counters();
  EXPECT_EQ(counters.accepted, 103u);
  EXPECT_GE(counters.crowded_out, 100u - 16u / 2);
}

/// A client with a token must keep its slot in spite of strangers. A new known client must replace
/// the client with the longest idle time.
TEST(Access, PlacesOfTheKnownAreTheirs) {
  Endpoint endpoint(patient(4), control::SceneList{});
  ControlClient first(endpoint.port(), AF_INET, test::admin_token().text, "127.0.1.1");
  ControlClient second(endpoint.port(), AF_INET, test::admin_token().text, "127.0.2.1");
  for (int i = 0; i < 50; ++i)
    RawSocket(SOCK_STREAM, endpoint.port(), AF_INET, "127.0.3.1")
        .send(std::vector<std::uint8_t>{1});
  first.ask<control::SceneList>(control::ListScenes{});
  second.ask<control::SceneList>(control::ListScenes{});
  first.ask<control::SceneList>(control::ListScenes{});
  ControlClient third(endpoint.port(), AF_INET, test::admin_token().text, "127.0.4.1");
  EXPECT_TRUE(second.closed());
  first.ask<control::SceneList>(control::ListScenes{});
  third.ask<control::SceneList>(control::ListScenes{});
}

/// Both clients need much memory: a stranger for its handshake, and a known client for its frame.
TEST(Access, StrangersAndEachClientHaveLimitsOfTheirOwn) {
  ControlOptions options = patient(64);
  options.max_strangers = 2;
  options.max_connections_per_client = 3;
  Endpoint endpoint(options, control::SceneList{});
  const auto known = [&](const char* from) {
    return std::make_unique<ControlClient>(endpoint.port(), AF_INET, test::admin_token().text,
                                           from);
  };
  const auto first = known("127.0.1.1"), second = known("127.0.2.1"), third = known("127.0.3.1");
  for (const auto* client : {&first, &second, &third})
    (*client)->ask<control::SceneList>(control::ListScenes{});
  const auto fourth = known("127.0.4.1");
  EXPECT_TRUE(first->closed());
  for (const auto* client : {&second, &third, &fourth})
    (*client)->ask<control::SceneList>(control::ListScenes{});
  RawSocket oldest(SOCK_STREAM, endpoint.port(), AF_INET, "127.0.5.1");
  const RawSocket older(SOCK_STREAM, endpoint.port(), AF_INET, "127.0.6.1");
  const RawSocket newest(SOCK_STREAM, endpoint.port(), AF_INET, "127.0.7.1");
  EXPECT_TRUE(oldest.receive().empty());
  EXPECT_EQ(endpoint.counters().crowded_out, 2u);
}

TEST(Access, HandshakesOfANetworkAreLimited) {
  ControlOptions options = patient(512);
  options.handshake_rate = 1e-3;
  options.handshake_burst = 3;
  options.handshake_patience = 10ms;  // Further handshakes must time out.
  Endpoint endpoint(options, control::SceneList{});
  for (const char* from : {"127.0.1.1", "127.0.1.2", "127.0.1.3"})
    EXPECT_TRUE(served(endpoint.port(), from));
  for (int i = 4; i < 24; ++i) {
    const std::string from = "127.0.1." + std::to_string(i);
    EXPECT_FALSE(served(endpoint.port(), from.c_str()));
  }
  EXPECT_TRUE(served(endpoint.port(), "127.0.2.1"));
  const ControlCounters counters = endpoint.counters();
  EXPECT_EQ(counters.accepted, 4u);
  EXPECT_EQ(counters.too_often, 20u);
}

/// An attack from the security review, on a complete endpoint: two neighbours connect repeatedly
/// and send nothing. All other hosts of the /24 must get in.
TEST(Access, ANeighbourWhoConnectsWithoutEndKeepsNobodyOut) {
  ControlOptions options = patient(512);
  options.handshake_rate = 50.0;
  options.handshake_burst = 100.0;
  Endpoint endpoint(options, control::SceneList{});
  std::atomic<bool> over{false};
  const auto attack = [&](const char* from) {
    std::deque<std::unique_ptr<RawSocket>> held;
    while (!over) try {
        held.push_back(std::make_unique<RawSocket>(SOCK_STREAM, endpoint.port(), AF_INET, from));
        if (held.size() > 64) held.pop_front();
      } catch (const std::runtime_error&) {  // The system has no free port at the moment.
        held.clear();
      }
  };
  std::thread first([&] { attack("127.0.9.1"); }), second([&] { attack("127.0.9.2"); });
  int kept_out = 0;
  for (int i = 10; i < 30; ++i) {
    const std::string from = "127.0.9." + std::to_string(i);
    kept_out += served(endpoint.port(), from.c_str()) ? 0 : 1;
  }
  over = true;
  first.join();
  second.join();
  EXPECT_EQ(kept_out, 0);
  EXPECT_GT(endpoint.counters().too_often, 0u);
}

}  // namespace
}  // namespace feltwire::access_test
