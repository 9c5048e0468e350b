// Tests epochs and who remembers them.

#include "protocol/fleet/epoch.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "protocol/fleet/epoch_memory.hpp"
#include "protocol/fleet/session_epoch.hpp"

namespace feltwire::epoch_test {
namespace {

constexpr HostNumber kA = 7, kB = 9;

TEST(Epoch, LaterTermsAreHigherWhoeverHoldsThem) {
  EXPECT_LT((Epoch{1, kB}), (Epoch{2, kA}));
  EXPECT_LT((Epoch{2, kA}), (Epoch{2, kB}));
  EXPECT_LT((Epoch{}), (Epoch{1, kA}));
  EXPECT_NE(next_epoch({4, kA}, kA), next_epoch({4, kA}, kB)) << "two processes, one epoch";
  EXPECT_GT(next_epoch({4, kB}, kA), (Epoch{4, kB}));
}

TEST(Epoch, MemoryRefusesALowerOneOfTheSameScene) {
  EpochMemory memory;
  EXPECT_EQ(memory.highest("room"), Epoch{});
  EXPECT_TRUE(memory.admit("room", {3, kA}));
  EXPECT_TRUE(memory.admit("room", {3, kA})) << "the same again";
  EXPECT_FALSE(memory.admit("room", {2, kB}));
  EXPECT_EQ(memory.highest("room"), (Epoch{3, kA})) << "a refused epoch leaves no trace";
  EXPECT_TRUE(memory.admit("hall", {1, kB})) << "another scene";
  EXPECT_TRUE(memory.admit("room", {3, kB}));
  EXPECT_FALSE(memory.admit("room", {3, kA}));
  EXPECT_EQ(memory.scenes(), 2u);
}

/// With such a term the next one would be 0, and each claim after it the same.
TEST(Epoch, ATermThatNoFleetReachesIsRefused) {
  constexpr Epoch kForged{std::numeric_limits<std::uint64_t>::max(), kB};
  Epoch highest{3, kA};
  EXPECT_FALSE(admit(highest, kForged));
  EXPECT_EQ(highest, (Epoch{3, kA}));
  EpochMemory memory;
  EXPECT_FALSE(memory.admit("room", kForged));
  EXPECT_EQ(memory.scenes(), 0u);
  SessionEpoch client;
  EXPECT_FALSE(take_session(client, kForged));
  EXPECT_FALSE(hear_epoch(client, kForged));
  EXPECT_EQ(client, SessionEpoch{});
  EXPECT_TRUE(admit(highest, {kMostTerm, kB}));
  EXPECT_FALSE(admit(highest, next_epoch(highest, kB)));
}

TEST(Epoch, AClientTakesNoSessionOfAFormerOwner) {
  SessionEpoch client;
  EXPECT_TRUE(take_session(client, {2, kA}));
  EXPECT_EQ(client.session, (Epoch{2, kA}));
  EXPECT_FALSE(take_session(client, {1, kB}));
  EXPECT_EQ(client.session, (Epoch{2, kA})) << "the session that it has stays";
  EXPECT_TRUE(take_session(client, {3, kB}));
  EXPECT_EQ(client, (SessionEpoch{{3, kB}, Epoch{3, kB}}));
}

TEST(Epoch, AClientLeavesAFormerOwner) {
  SessionEpoch client;
  EXPECT_FALSE(hear_epoch(client, {1, kA})) << "there is no session to end";
  ASSERT_TRUE(take_session(client, {2, kA}));
  EXPECT_FALSE(hear_epoch(client, {1, kB})) << "an old record";
  EXPECT_FALSE(hear_epoch(client, {2, kA})) << "its own";
  EXPECT_TRUE(client.session.has_value());
  EXPECT_TRUE(hear_epoch(client, {3, kB}));
  EXPECT_FALSE(client.session.has_value());
  EXPECT_FALSE(take_session(client, {2, kA})) << "it does not go back";
}

}  // namespace
}  // namespace feltwire::epoch_test
