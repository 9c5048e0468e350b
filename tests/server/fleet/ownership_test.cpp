// Tests the steps of one host, one by one. ownership_search_test.cpp tries all orders of many.

#include "server/fleet/ownership.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace feltwire::ownership_test {
namespace {

const HostName kA{"a", 11}, kB{"b", 22}, kC{"c", 33};
const SceneDigest kDigest{1, 2, 3};

/// The ownership of host A, which has claimed the scene at revision 1.
SceneOwnership owner() {
  SceneOwnership scene;
  const SceneRecord record = claim(scene, kA, kDigest);
  EXPECT_TRUE(finish_claim(scene, record, 1));
  return scene;
}

/// The record of A with the standby B.
SceneRecord with_standby() {
  SceneOwnership scene = owner();
  reserve_standby(scene, kB);
  return *record_to_write(scene);
}

/// The knowledge of a host that has read this record and serves nothing.
SceneOwnership reader_of(const SceneRecord& record) {
  SceneOwnership scene;
  EXPECT_FALSE(see_record(scene, record, 5));
  return scene;
}

TEST(Ownership, AHostServesWhenItsClaimIsAcknowledged) {
  SceneOwnership scene;
  const SceneRecord record = claim(scene, kA, kDigest);
  EXPECT_EQ(record, (SceneRecord{kA, {{1, kA.number}, 1}, {}, kDigest, false}));
  EXPECT_FALSE(scene.serving) << "before the answer";
  EXPECT_EQ(answer_join(scene, {}), JoinAnswer::unknown);
  EXPECT_TRUE(finish_claim(scene, record, 1));
  EXPECT_EQ(scene.serving, (Epoch{1, kA.number}));
  EXPECT_EQ(record_to_write(scene), std::nullopt);
}

TEST(Ownership, EachClaimHasAnEpochOfItsOwn) {
  SceneOwnership scene;
  const SceneRecord first = claim(scene, kA, kDigest), second = claim(scene, kA, kDigest);
  EXPECT_GT(second.version.epoch, first.version.epoch);
  see_epoch(scene, {7, kB.number});
  EXPECT_EQ(claim(scene, kA, kDigest).version.epoch, (Epoch{8, kA.number}));
}

/// A damaged record must not end the scene for ever: terms after the last one begin at 0 again.
TEST(Ownership, AClaimReplacesARecordOfAnImpossibleTerm) {
  SceneRecord forged = with_standby();
  forged.version.epoch = {std::numeric_limits<std::uint64_t>::max(), kC.number};
  forged.owner = kC;
  SceneOwnership serving = owner();
  EXPECT_FALSE(see_record(serving, forged, 6));
  EXPECT_TRUE(serving.serving) << "it goes on";
  EXPECT_NE(record_to_write(serving), std::nullopt) << "and writes its own record again";
  SceneOwnership reader = reader_of(forged);
  EXPECT_EQ(answer_join(reader, {}), JoinAnswer::unknown) << "no redirect to a forged owner";
  EXPECT_FALSE(take_over(reader, kB));
  const SceneRecord record = claim(reader, kB, kDigest);
  EXPECT_EQ(record.version.epoch, (Epoch{1, kB.number}));
  EXPECT_EQ(reader.revision, 5u) << "of the entry that the claim replaces";
  EXPECT_TRUE(finish_claim(reader, record, 7));
  EXPECT_EQ(record_to_write(reader), std::nullopt);
  EXPECT_EQ(answer_join(reader, {}), JoinAnswer::accepted);
}

TEST(Ownership, AClaimThatIsAnsweredTooLateServesNothing) {
  SceneOwnership scene;
  const SceneRecord record = claim(scene, kA, kDigest);
  see_epoch(scene, {2, kB.number});
  EXPECT_FALSE(finish_claim(scene, record, 1));
  EXPECT_FALSE(scene.serving);
}

TEST(Ownership, AnOwnerLetsGoAtAHigherEpochOnly) {
  SceneOwnership scene = owner();
  SceneRecord other{kB, {{1, kB.number}, 1}, {}, kDigest, false};
  EXPECT_TRUE(see_record(scene, other, 2)) << "same term, higher number";
  EXPECT_FALSE(scene.serving);
  EXPECT_EQ(answer_join(scene, {}), JoinAnswer::redirected);

  scene = owner();
  other = {{"lower", 3}, {{1, 3}, 1}, {}, kDigest, false};
  EXPECT_FALSE(see_record(scene, other, 2));
  EXPECT_TRUE(scene.serving);
  ASSERT_TRUE(record_to_write(scene)) << "the directory has a record that is not the owner's";
  EXPECT_EQ(record_to_write(scene)->owner, kA);
  EXPECT_EQ(scene.revision, 2u) << "and it will be written over that";
}

TEST(Ownership, AnOldRecordChangesNothing) {
  SceneOwnership scene = owner();
  const SceneRecord first = scene.record;
  reserve_standby(scene, kB);
  const SceneRecord second = *record_to_write(scene);
  finish_write(scene, second, 2);
  EXPECT_EQ(record_to_write(scene), std::nullopt);
  EXPECT_FALSE(see_record(scene, first, 1)) << "delivered twice";
  EXPECT_EQ(scene.record, second);
  EXPECT_EQ(record_to_write(scene), second) << "if the directory has forgotten it";
}

TEST(Ownership, TheStandbyTakesOverWithoutAWrite) {
  const SceneRecord record = with_standby();
  SceneOwnership scene = reader_of(record);
  EXPECT_FALSE(take_over(scene, kC)) << "it is not C's to take";
  EXPECT_TRUE(take_over(scene, kB));
  EXPECT_EQ(scene.serving, reserved_epoch(record));
  EXPECT_EQ(answer_join(scene, record.version.epoch), JoinAnswer::accepted);
  ASSERT_TRUE(record_to_write(scene)) << "the directory is told afterwards";
  EXPECT_EQ(record_to_write(scene)->owner, kB);
  EXPECT_EQ(record_to_write(scene)->standby.number, 0u);
  EXPECT_EQ(scene.record.digest, kDigest);
  EXPECT_FALSE(take_over(scene, kB)) << "it serves already";

  SceneOwnership former = owner();
  EXPECT_TRUE(see_record(former, *record_to_write(scene), 9));
}

TEST(Ownership, AHandoverEndsTheJoinsFirstAndTheSessionsLast) {
  SceneOwnership scene = owner();
  hand_over(scene, kB);
  EXPECT_FALSE(scene.serving);
  EXPECT_EQ(scene.leaving, (Epoch{1, kA.number}));
  EXPECT_EQ(answer_join(scene, {}), JoinAnswer::unknown) << "neither here nor there yet";
  const auto record = record_to_write(scene);
  ASSERT_TRUE(record);
  EXPECT_TRUE(record->handed_over);

  SceneOwnership other = reader_of(*record);
  EXPECT_FALSE(is_handed_to(other, kC));
  EXPECT_FALSE(is_handed_to(other, {kB.name, kB.number + 1})) << "a process that began anew";
  ASSERT_TRUE(is_handed_to(other, kB));
  EXPECT_EQ(answer_join(other, {}), JoinAnswer::unknown) << "no redirect to the former owner";
  ASSERT_TRUE(take_over(other, kB));
  EXPECT_FALSE(is_handed_to(other, kB));
  const auto next = record_to_write(other);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->version.epoch, (Epoch{2, kB.number}));
  EXPECT_FALSE(next->handed_over);

  finish_write(scene, *record, 2);
  EXPECT_EQ(record_to_write(scene), std::nullopt);
  EXPECT_FALSE(see_record(scene, *record, 2)) << "its own record ends nothing";
  EXPECT_TRUE(see_record(scene, *next, 3)) << "now the sessions end";
  EXPECT_FALSE(scene.leaving);
  EXPECT_EQ(answer_join(scene, {}), JoinAnswer::redirected);
}

/// The target has died, say. The sessions have gone on all the time.
TEST(Ownership, AFormerOwnerTakesBackWhatNobodyTook) {
  SceneOwnership scene = owner();
  hand_over(scene, kB);
  const SceneRecord record = claim(scene, kA, kDigest);
  EXPECT_EQ(record.version.epoch, (Epoch{3, kA.number})) << "beyond the target's";
  EXPECT_FALSE(see_record(scene, record, 3)) << "seen before the answer to the claim";
  EXPECT_TRUE(scene.leaving);
  EXPECT_TRUE(finish_claim(scene, record, 3));
  EXPECT_EQ(scene.serving, (Epoch{3, kA.number}));
  EXPECT_FALSE(scene.leaving);
  SceneOwnership late = reader_of(*record_to_write([] {
    SceneOwnership before = owner();
    hand_over(before, kB);
    return before;
  }()));
  ASSERT_TRUE(take_over(late, kB));
  EXPECT_FALSE(see_record(scene, *record_to_write(late), 4)) << "it comes too late";
  EXPECT_TRUE(see_record(late, record, 3));
}

TEST(Ownership, AStandbyThatKnowsOfALaterOwnerStays) {
  SceneOwnership scene = reader_of(with_standby());
  see_epoch(scene, {4, kC.number});
  EXPECT_FALSE(take_over(scene, kB));
  EXPECT_FALSE(scene.serving);
  EXPECT_EQ(scene.highest, (Epoch{4, kC.number}));
}

TEST(Ownership, AStandbyThatStartedAgainIsNoStandby) {
  SceneOwnership scene = reader_of(with_standby());
  EXPECT_FALSE(take_over(scene, {kB.name, kB.number + 1}));
}

TEST(Ownership, AClientWithALaterEpochIsNotAccepted) {
  const SceneOwnership scene = owner();
  EXPECT_EQ(answer_join(scene, {}), JoinAnswer::accepted);
  EXPECT_EQ(answer_join(scene, {1, kA.number}), JoinAnswer::accepted);
  EXPECT_EQ(answer_join(scene, {2, kB.number}), JoinAnswer::unknown);
  EXPECT_TRUE(scene.serving) << "a client's word takes no scene from its owner";
}

TEST(Ownership, ARedirectNeverLeadsBack) {
  SceneOwnership scene = reader_of(with_standby());
  EXPECT_EQ(answer_join(scene, {}), JoinAnswer::redirected);
  EXPECT_EQ(answer_join(scene, {2, kB.number}), JoinAnswer::unknown) << "the client knows more";
  see_epoch(scene, {2, kB.number});
  EXPECT_EQ(answer_join(scene, {}), JoinAnswer::unknown) << "the host knows of a later owner";
  EXPECT_EQ(answer_join(SceneOwnership{}, {}), JoinAnswer::unknown);
}

}  // namespace
}  // namespace feltwire::ownership_test
