#include "client/transport/transport.hpp"

#include <gtest/gtest.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/wait.h>

#include <numeric>

#include "protocol/net/udp_socket.hpp"
#include "tests/client/peer.hpp"

namespace feltwire::transport_test {
namespace {

using testing::ScenePeer;
using Arrival = Transport::Arrival;

Sample sample(std::uint64_t index) {
  Sample s;
  s.index = index;
  s.client_time = Nanoseconds(static_cast<std::int64_t>(index) * 1'000'000);
  s.pose.position = Vec3(static_cast<double>(index), 0.5, -0.25);
  s.held.elastic = Vec3(0, 0, 1.5);
  return s;
}

SessionParameters repeating(int redundancy) {
  SessionParameters p;
  p.redundancy = redundancy;
  return p;
}

struct Link {
  ScenePeer peer;
  Transport transport;
  Reply reply;
  GoodbyeReason reason = GoodbyeReason::leaving;

  explicit Link(int redundancy = 3, bool rotation = false)
      : transport(peer.session(), repeating(redundancy), rotation) {
    transport.send(sample(1));  // The peer gets the client's address from this sample.
    peer.receive();
  }
  Arrival receive() { return transport.receive(reply, reason); }
  std::uint64_t dropped(DropReason why) const {
    return transport.statistics().dropped[static_cast<std::size_t>(why)];
  }
  std::uint64_t dropped() const {
    const auto all = transport.statistics().dropped;
    return std::accumulate(all.begin(), all.end(), std::uint64_t{0});
  }
};

TEST(Transport, EachSampleTravelsWithTheOnesBefore) {
  for (const int k : {0, 3, kMaxRedundancy}) {
    Link link(k);
    for (std::uint64_t i = 2; i <= 12; ++i) {
      link.transport.send(sample(i));
      const auto received = link.peer.receive();
      ASSERT_EQ(received.kind, DatagramKind::samples);
      EXPECT_EQ(received.header.session, ScenePeer::kSession);
      EXPECT_EQ(received.header.packet_number, i);
      const auto expected = std::min<std::uint64_t>(static_cast<std::uint64_t>(k) + 1, i);
      ASSERT_EQ(static_cast<std::uint64_t>(received.batch.count), expected);
      EXPECT_EQ(received.batch.previous, i - expected);
      for (std::uint64_t j = 0; j < expected; ++j) {
        const Sample& s = received.batch.samples[j];
        EXPECT_EQ(s.index, i - j);
        EXPECT_EQ(s.client_time, sample(i - j).client_time);
        EXPECT_EQ(s.pose.position, sample(i - j).pose.position);
        EXPECT_EQ(s.held.elastic, sample(i - j).held.elastic);
      }
    }
    const TransportStatistics s = link.transport.statistics();
    EXPECT_EQ(s.sent, 12u);
    EXPECT_EQ(s.send_failed + s.too_long + s.rerouted + s.received + link.dropped(), 0u);
  }
}

TEST(Transport, OrientationTravelsWhereItIsSensed) {
  Link link(2, true);
  Sample turned = sample(2);
  turned.pose.orientation = Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitX()));
  link.transport.send(turned);
  const auto received = link.peer.receive();
  EXPECT_TRUE(received.batch.rotation);
  EXPECT_TRUE(received.batch.samples[0].pose.orientation.isApprox(turned.pose.orientation, 1e-12));
}

TEST(Transport, TakesRepliesAndGoodbyes) {
  Link link;
  EXPECT_EQ(link.receive(), Arrival::nothing);
  link.peer.send(ScenePeer::reply_to(sample(1), {.elastic = Vec3(0, 0, 2.5)}));
  link.peer.send(GoodbyeReason::shutting_down);
  EXPECT_EQ(link.receive(), Arrival::reply);
  EXPECT_EQ(link.reply.sample_index, 1u);
  EXPECT_EQ(link.reply.command.elastic, Vec3(0, 0, 2.5));
  EXPECT_EQ(link.receive(), Arrival::goodbye);
  EXPECT_EQ(link.reason, GoodbyeReason::shutting_down);
  EXPECT_EQ(link.receive(), Arrival::nothing);
  EXPECT_EQ(link.transport.statistics().received, 2u);
  EXPECT_EQ(link.dropped(), 0u);
}

TEST(Transport, BadDatagramsAreCountedAndWhatFollowsIsTaken) {
  Link link;
  test::SealedEncoder& encoder = link.peer.encoder();
  const Reply good = ScenePeer::reply_to(sample(1));
  const auto bytes = [](Bytes b) { return std::vector<std::uint8_t>(b.begin(), b.end()); };

  link.peer.send_bytes(std::vector<std::uint8_t>{1, 2, 3});
  link.peer.send_bytes(std::vector<std::uint8_t>(kMaxDatagram + 1));
  auto garbage = bytes(encoder.reply(ScenePeer::kSession, 900, good));
  garbage[0] ^= 0xff;
  link.peer.send_bytes(garbage);
  link.peer.send_bytes(bytes(encoder.reply(ScenePeer::kSession + 1, 901, good)));
  SampleBatch batch;
  batch.count = 1;
  batch.samples[0] = sample(1);
  link.peer.send_bytes(
      bytes(encoder.samples(ScenePeer::kSession, 902, batch)));  // Only a server accepts this kind.
  auto cut = bytes(encoder.reply(ScenePeer::kSession, 903, good));
  cut.resize(cut.size() - 30);
  link.peer.send_bytes(cut);
  const std::vector<std::uint8_t> unsound(64, 0xff);
  link.peer.send_bytes(
      bytes(encoder.seal({DatagramKind::reply, ScenePeer::kSession, 906}, unsound)));
  Reply nan = good;
  nan.command.elastic.x() = std::nan("");
  link.peer.send_bytes(bytes(encoder.reply(ScenePeer::kSession, 904, nan)));
  const auto twice = bytes(encoder.reply(ScenePeer::kSession, 905, good));
  link.peer.send_bytes(twice);
  link.peer.send_bytes(twice);

  EXPECT_EQ(link.receive(), Arrival::reply);
  EXPECT_EQ(link.receive(), Arrival::nothing);
  EXPECT_EQ(link.dropped(DropReason::size), 2u);
  EXPECT_EQ(link.dropped(DropReason::magic), 1u);
  EXPECT_EQ(link.dropped(DropReason::session), 1u);
  EXPECT_EQ(link.dropped(DropReason::kind), 1u);
  EXPECT_EQ(link.dropped(DropReason::sealed), 1u);
  EXPECT_EQ(link.dropped(DropReason::malformed), 1u);
  EXPECT_EQ(link.dropped(DropReason::not_finite), 1u);
  EXPECT_EQ(link.dropped(DropReason::packet_number), 1u);
  EXPECT_EQ(link.dropped(), 9u);  // The transport drops no other datagram.
  EXPECT_EQ(link.transport.statistics().received, 10u);
}

TEST(Transport, ForeignSendersAreNotHeard) {
  Link link;
  testing::LocalSocket stranger(SOCK_DGRAM);
  sockaddr_storage client{};
  socklen_t size = sizeof client;
  ASSERT_EQ(::getsockname(link.transport.port().descriptor(), reinterpret_cast<sockaddr*>(&client),
                          &size),
            0);
  test::SealedEncoder encoder(test::Way::down);
  const Bytes forged = encoder.goodbye(ScenePeer::kSession, 1, GoodbyeReason::evicted);
  ASSERT_GT(::sendto(stranger.descriptor(), forged.data(), forged.size(), 0,
                     reinterpret_cast<sockaddr*>(&client), size),
            0);
  EXPECT_EQ(link.receive(), Arrival::nothing);
  EXPECT_EQ(link.transport.statistics().received, 0u);
  // The client takes these bytes from the peer. Only the sender's address was wrong.
  link.peer.send_bytes(forged);
  EXPECT_EQ(link.receive(), Arrival::goodbye);
  EXPECT_EQ(link.reason, GoodbyeReason::evicted);
  EXPECT_EQ(link.transport.statistics().received, 1u);
}

TEST(Transport, AFloodIsTakenInPortions) {
  Link link;
  for (int i = 0; i < DatagramPort::kBurst + 10; ++i)
    link.peer.send_bytes(std::vector<std::uint8_t>{0});
  link.peer.send(ScenePeer::reply_to(sample(1)));
  EXPECT_EQ(link.receive(), Arrival::nothing);
  EXPECT_EQ(link.dropped(DropReason::size), static_cast<std::uint64_t>(DatagramPort::kBurst));
  EXPECT_EQ(link.transport.statistics().received, static_cast<std::uint64_t>(DatagramPort::kBurst));
  EXPECT_EQ(link.receive(), Arrival::reply);
  EXPECT_EQ(link.dropped(), static_cast<std::uint64_t>(DatagramPort::kBurst + 10));
  EXPECT_EQ(link.transport.statistics().received,
            static_cast<std::uint64_t>(DatagramPort::kBurst + 11));
}

/// A sender that mixes valid replies into a flood must not prolong a wake-up.
TEST(Transport, AFloodAroundRepliesCountsAsAWhole) {
  Link link;
  constexpr int kMost = 64;
  for (int n = 0; n < kMost; ++n) {
    link.peer.send_bytes(std::vector<std::uint8_t>{0});
    link.peer.send(ScenePeer::reply_to(sample(1)));
  }
  int left = kMost, replies = 0;
  while (link.transport.receive(link.reply, link.reason, left) == Arrival::reply) ++replies;
  EXPECT_EQ(replies, kMost / 2);
  EXPECT_EQ(left, 0);
  EXPECT_EQ(link.transport.statistics().received, static_cast<std::uint64_t>(kMost));
}

TEST(Transport, GoodbyeIsSaidThreeTimes) {
  Link link;
  link.transport.goodbye();
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto received = link.peer.receive();
    EXPECT_EQ(received.kind, DatagramKind::goodbye);
    EXPECT_EQ(received.reason, GoodbyeReason::leaving);
    EXPECT_EQ(received.header.packet_number, 2 + i);
  }
  EXPECT_EQ(link.transport.statistics().sent, 1u + 3u);
}

TEST(Transport, FromAnotherPortTheConversationGoesOn) {
  Link link;
  const auto port = [&] {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    EXPECT_EQ(
        ::getsockname(link.transport.port().descriptor(), reinterpret_cast<sockaddr*>(&own), &size),
        0);
    return own.sin_port;
  };
  const auto before = port();
  EXPECT_TRUE(link.transport.port().reroute());
  EXPECT_NE(port(), before);
  link.transport.send(sample(2));
  EXPECT_EQ(link.peer.receive().header.packet_number, 2u);
  link.peer.send(ScenePeer::reply_to(sample(2)));
  EXPECT_EQ(link.receive(), Arrival::reply);
  EXPECT_EQ(link.transport.statistics().rerouted, 1u);
}

/// The transport does not read for some time. The full socket buffer loses datagrams. The transport
/// then takes the rest in portions, and the newest reply arrives.
TEST(Transport, WhatPiledUpUnreadIsTakenOrLost) {
  Link link;
  constexpr std::uint64_t kPile = 5000;
  for (std::uint64_t n = 0; n < kPile; ++n) link.peer.send(ScenePeer::reply_to(sample(1)));
  std::uint64_t taken = 0;
  while (link.receive() == Arrival::reply) ++taken;
  EXPECT_GT(taken, 0u);
  EXPECT_LT(taken, kPile);
  link.peer.send(ScenePeer::reply_to(sample(7)));
  EXPECT_EQ(link.receive(), Arrival::reply);
  EXPECT_EQ(link.reply.sample_index, 7u);
  // The system lost the other datagrams. The transport must drop none.
  EXPECT_EQ(link.transport.statistics().received, taken + 1);
  EXPECT_EQ(link.dropped(), 0u);
}

TEST(Transport, DatagramsAreMarkedAndNeverCut) {
  const ScenePeer peer;
  for (const int mark : {0, 46, 40}) {
    const Transport transport(peer.session(), {}, false,
                              open_udp_port(peer.session().server, mark));
    EXPECT_EQ(get_dscp(transport.port().descriptor()), mark);
    int discover = -1;
    socklen_t size = sizeof discover;
    ::getsockopt(transport.port().descriptor(), IPPROTO_IP, IP_MTU_DISCOVER, &discover, &size);
    EXPECT_EQ(discover, IP_PMTUDISC_DO);
  }
}

constexpr int kNotPermitted = 77;

/// Runs in a network namespace with an MTU of 600 bytes. Returns the exit status.
int send_through_a_narrow_path() {
  if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return kNotPermitted;
  const int any = ::socket(AF_INET, SOCK_DGRAM, 0);
  ifreq line{};
  std::strcpy(line.ifr_name, "lo");
  line.ifr_mtu = 600;
  if (::ioctl(any, SIOCSIFMTU, &line) != 0) return kNotPermitted;
  line.ifr_flags = IFF_UP | IFF_RUNNING;
  if (::ioctl(any, SIOCSIFFLAGS, &line) != 0) return kNotPermitted;

  ScenePeer peer;
  Transport transport(peer.session(), repeating(kMaxRedundancy), true);
  for (std::uint64_t n = 1; n <= 40; ++n) transport.send(sample(n));
  const TransportStatistics s = transport.statistics();
  if (s.too_long == 0 || s.too_long != s.send_failed || s.rerouted != 0) return 1;
  if (s.sent + s.send_failed != 40) return 2;
  int count = 0;
  std::uint64_t newest = 0;
  for (std::uint64_t n = 0; n < s.sent; ++n) {
    const auto received = peer.receive();
    if (received.kind != DatagramKind::samples) return 3;
    count = received.batch.count;
    newest = received.batch.samples[0].index;
  }
  // The batch has the largest number of samples that fits: fewer than requested, but more than one.
  if (newest != 40 || count < 2 || count > kMaxRedundancy) return 4;
  // A new session measures the path again.
  transport.resume(peer.session());
  for (std::uint64_t n = 41; n <= 60; ++n) transport.send(sample(n));
  return transport.statistics().too_long == 2 * s.too_long ? 0 : 5;
}

TEST(Transport, WhereThePathIsNarrowDatagramsCarryFewerSamples) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) ::_exit(send_through_a_narrow_path());
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNotPermitted)
    GTEST_SKIP() << "this machine permits no network of one's own (user namespaces)";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(Transport, AClosedPortIsCountedNotFatal) {
  Address gone;
  {
    const ScenePeer peer;
    gone = peer.address();
  }
  Transport transport({gone, 1, test::keys(1)}, {}, false);
  transport.send(sample(1));
  transport.send(sample(2));
  Reply reply;
  GoodbyeReason reason;
  EXPECT_EQ(transport.receive(reply, reason), Arrival::nothing);
  // The system reports the closed port at the second send, and does not send the datagram. The
  // transport must not reroute.
  const TransportStatistics s = transport.statistics();
  EXPECT_EQ(s.sent, 1u);
  EXPECT_EQ(s.send_failed, 1u);
  EXPECT_EQ(s.too_long + s.rerouted + s.received, 0u);
}

}  // namespace
}  // namespace feltwire::transport_test
