// A client applies the changes that its server requests, and limits the number of changes.

#include "client/run/changes.hpp"

#include <gtest/gtest.h>

#include "tests/client/peer.hpp"

namespace feltwire::changes_test {
namespace {

struct Hand {
  DeviceSpec spec = builtin_device("simulated");
  SessionParameters started = [] {
    SessionParameters p;
    p.side = BoundingSide::client;
    p.mode = "contact_frame";
    return p;
  }();
  ServoOptions options;
  testing::ScenePeer peer;
  Transport transport{peer.session(), {}, false};
  Changes changes{
      {spec, started, options, transport.port(), {.laws = LawsTaken::any, .link = false}}};

  ClientChange wish(std::uint8_t number, const char* mode) const {
    SessionParameters p = started;
    p.mode = mode;
    return {.number = number, .law = law_of(p), .link = {}};
  }
};

/// A server sends requests forever. The client must answer, but its memory must not grow.
TEST(Changes, AreBoundedWhateverAServerSends) {
  Hand hand;
  std::uint8_t number = 0;
  constexpr std::size_t kFlood = 3 * Changes::kMost;
  for (std::size_t i = 0; i < kFlood; ++i) {
    number = number_after(number);
    ASSERT_TRUE(hand.changes.wanted().push(
        {hand.wish(number, i % 2 == 0 ? "shaped" : "contact_frame"), 0}));
    const Changes::Done* done = hand.changes.next(0);
    ASSERT_NE(done, nullptr);
    PreparedChange* ready = nullptr;
    ASSERT_TRUE(hand.changes.ready().pop(ready));
    EXPECT_EQ(ready, &done->prepared);
    EXPECT_EQ(ready->number, number);
    EXPECT_EQ(ready->refused, i >= Changes::kMost) << i << ": " << done->refusal;
  }
  EXPECT_EQ(hand.changes.done().size(), Changes::kMost);
  // the bounding method of the last accepted change
  EXPECT_EQ(hand.changes.law(), law_of(hand.started));
}

/// A change for an earlier session must not apply to the next session.
TEST(Changes, OfAnOlderSessionArePassedOver) {
  Hand hand;
  ASSERT_TRUE(hand.changes.wanted().push({hand.wish(1, "shaped"), 0}));
  EXPECT_EQ(hand.changes.next(1), nullptr);
  EXPECT_EQ(hand.changes.law(), law_of(hand.started));
  ASSERT_TRUE(hand.changes.wanted().push({hand.wish(1, "shaped"), 0}));
  ASSERT_TRUE(hand.changes.wanted().push({hand.wish(2, "shaped"), 1}));
  const Changes::Done* done = hand.changes.next(1);
  ASSERT_NE(done, nullptr);
  EXPECT_EQ(done->prepared.number, 2);
  EXPECT_EQ(done->prepared.session, 1u);
  EXPECT_EQ(done->refusal, "");
  EXPECT_EQ(hand.changes.law(), *hand.wish(2, "shaped").law);
}

}  // namespace
}  // namespace feltwire::changes_test
