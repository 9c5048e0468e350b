// Tests the transport with an emulated link. The test sets the time.

#include <gtest/gtest.h>
#include <poll.h>

#include "client/emulated_link/emulated_port.hpp"
#include "client/transport/transport.hpp"
#include "tests/client/peer.hpp"

namespace feltwire::transport_link_test {
namespace {

using testing::ScenePeer;
using Arrival = Transport::Arrival;
using Milliseconds = std::chrono::milliseconds;

Sample sample(std::uint64_t index) {
  Sample s;
  s.index = index;
  return s;
}

struct Linked {
  ScenePeer peer;
  Transport transport;
  Reply reply;
  GoodbyeReason reason = GoodbyeReason::leaving;

  explicit Linked(const char* link)
      : transport(peer.session(), {}, false,
                  std::make_unique<EmulatedPort>(open_udp_port(peer.session().server),
                                                 TwoWayLink(parse_link(link), 0, 1024))) {}
  const TwoWayLink& link() const {
    return dynamic_cast<const EmulatedPort&>(transport.port()).link();
  }
  /// Waits until the peer's datagram is in the transport's socket.
  void await_arrival() const {
    pollfd readable{transport.port().descriptor(), POLLIN, 0};
    ASSERT_EQ(::poll(&readable, 1, 10'000), 1);
  }
};

TEST(TransportLink, SamplesLeaveAndRepliesArriveWhenTheyAreDue) {
  Linked linked("up.delay=20,down.delay=5");
  Transport& transport = linked.transport;
  transport.port().pass(Milliseconds(100));
  EXPECT_EQ(transport.port().next_due(), std::nullopt);
  transport.send(sample(1));
  EXPECT_EQ(transport.port().next_due(), Milliseconds(120));
  transport.port().pass(Milliseconds(119));
  EXPECT_EQ(transport.statistics().sent, 0u);
  transport.port().pass(Milliseconds(120));
  EXPECT_EQ(transport.statistics().sent, 1u);
  EXPECT_EQ(linked.peer.receive().batch.samples[0].index, 1u);

  linked.peer.send(ScenePeer::reply_to(sample(1)));
  linked.await_arrival();
  transport.port().pass(Milliseconds(130));
  EXPECT_EQ(linked.transport.receive(linked.reply, linked.reason), Arrival::nothing);
  EXPECT_EQ(transport.port().next_due(), Milliseconds(135));
  transport.port().pass(Milliseconds(135));
  EXPECT_EQ(linked.transport.receive(linked.reply, linked.reason), Arrival::reply);
  EXPECT_EQ(linked.reply.sample_index, 1u);
  EXPECT_EQ(linked.transport.receive(linked.reply, linked.reason), Arrival::nothing);
}

TEST(TransportLink, WithoutDelayASampleLeavesAtOnce) {
  Linked linked("delay=0");
  linked.transport.port().pass(Milliseconds(1));
  linked.transport.send(sample(1));
  EXPECT_EQ(linked.peer.receive().batch.samples[0].index, 1u);
}

TEST(TransportLink, LossIsTheLinksNotTheSystems) {
  Linked linked("up.loss=100");
  linked.transport.port().pass(Milliseconds(1));
  for (std::uint64_t i = 1; i <= 5; ++i) linked.transport.send(sample(i));
  EXPECT_EQ(linked.transport.port().next_due(), std::nullopt);
  EXPECT_EQ(linked.transport.statistics().sent, 0u);
  EXPECT_EQ(linked.link().up.statistics().lost, 5u);
}

TEST(TransportLink, ADuplicateIsSentTwiceAndAReplyTakenOnce) {
  Linked linked("duplicate=100");
  linked.transport.port().pass(Milliseconds(1));
  linked.transport.send(sample(1));
  EXPECT_EQ(linked.peer.receive().header.packet_number, 1u);
  EXPECT_EQ(linked.peer.receive().header.packet_number, 1u);
  linked.peer.send(ScenePeer::reply_to(sample(1)));
  linked.await_arrival();
  linked.transport.port().pass(Milliseconds(2));
  EXPECT_EQ(linked.transport.receive(linked.reply, linked.reason), Arrival::reply);
  EXPECT_EQ(linked.transport.receive(linked.reply, linked.reason), Arrival::nothing);
  EXPECT_EQ(
      linked.transport.statistics().dropped[static_cast<std::size_t>(DropReason::packet_number)],
      1u);
}

TEST(TransportLink, AGoodbyeGoesPastTheLink) {
  Linked linked("delay=1000,loss=100");
  linked.transport.goodbye();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(linked.peer.receive().kind, DatagramKind::goodbye);
}

}  // namespace
}  // namespace feltwire::transport_link_test
