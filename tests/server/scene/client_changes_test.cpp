// Changes that a session's client makes itself, and its answers to them.

#include "server/scene/client_changes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/make_slot.hpp"

namespace feltwire::client_changes_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Bench {
  Bench() { slots.push_back(test::make_slot(scene, 1, bounded_by_client())); }

  static control::JoinRequest bounded_by_client() {
    SessionParameters parameters;
    parameters.side = BoundingSide::client;
    return test::join_request(parameters);
  }
  SessionSlot& slot() { return *slots.front(); }
  LawChoice law() { return law_of(slot().session.parameters()); }
  /// Asks the client for a law that differs in its storage.
  void ask_for(Storage storage) {
    LawChoice wanted = law();
    wanted.storage = storage;
    AskedChange asked = next_change(slot(), ClientChange{.law = wanted, .link = {}});
    asked.parameters = with_law(asked.parameters, wanted);
    slot().asked = asked;
  }
  /// The client answers the newest change.
  void answer(bool refused) {
    HandReport report;
    report.change = slot().asked->change.number;
    report.change_refused = refused;
    changes.hear(slot(), report);
  }

  const Scene scene = test::room();
  SessionSlots slots;
  ClientChanges changes;
};

TEST(ClientChanges, TheLawIsInForceWhenTheClientHasTakenIt) {
  Bench bench;
  const Storage before = bench.law().storage;
  const Storage other = before == Storage::minimal ? Storage::elastic : Storage::minimal;
  bench.ask_for(other);
  EXPECT_TRUE(bench.slot().waits_for_client());
  EXPECT_EQ(bench.slot().asked->change.number, 1);

  HandReport other_number;
  other_number.change = 9;
  bench.changes.hear(bench.slot(), other_number);
  bench.changes.hear(bench.slot(), std::nullopt);
  EXPECT_TRUE(bench.slot().waits_for_client());
  EXPECT_EQ(bench.law().storage, before);
  EXPECT_FALSE(bench.changes.has_answers());

  bench.answer(false);
  EXPECT_FALSE(bench.slot().waits_for_client());
  EXPECT_EQ(bench.law().storage, other);
  EXPECT_TRUE(bench.changes.has_answers());
  EXPECT_THAT(
      bench.changes.answers(bench.slots),
      ElementsAre(HasSubstr("session 1 (tester): its client has taken the change: storage")));
  EXPECT_FALSE(bench.changes.has_answers());
  EXPECT_TRUE(bench.changes.answers(bench.slots).empty());
}

TEST(ClientChanges, ARefusedLawIsNotInForce) {
  Bench bench;
  const LawChoice before = bench.law();
  bench.ask_for(Storage::elastic);
  bench.answer(true);
  EXPECT_EQ(bench.law(), before);
  EXPECT_THAT(bench.changes.answers(bench.slots), ElementsAre(HasSubstr("has refused the change")));
}

TEST(ClientChanges, ANewChangeIncludesTheOneThatWaits) {
  Bench bench;
  bench.ask_for(Storage::elastic);
  const LinkQuality link{.delay = 0.02};
  const AskedChange next = next_change(bench.slot(), ClientChange{.law = {}, .link = link});
  EXPECT_EQ(next.change.number, 2);
  ASSERT_TRUE(next.change.law);
  EXPECT_EQ(next.change.law->storage, Storage::elastic);
  EXPECT_EQ(next.change.link, link);
  EXPECT_TRUE(next.unheard_law);
}

/// The client may have taken the first law before it refused the second one.
TEST(ClientChanges, AfterARefusalOfTwoLawsTheClientReturnsToTheLawOfItsSession) {
  Bench bench;
  const LawChoice before = bench.law();
  bench.ask_for(Storage::elastic);
  bench.ask_for(Storage::elastic);
  bench.answer(true);
  ASSERT_TRUE(bench.slot().waits_for_client());
  EXPECT_TRUE(bench.slot().asked->returns);
  EXPECT_EQ(bench.slot().asked->change.law, before);
  EXPECT_EQ(bench.slot().asked->change.number, 3);
  EXPECT_THAT(bench.changes.answers(bench.slots),
              ElementsAre(HasSubstr("it is asked to return to the law of its session")));
  bench.answer(false);
  EXPECT_FALSE(bench.slot().waits_for_client());
  EXPECT_EQ(bench.law(), before);
}

}  // namespace
}  // namespace feltwire::client_changes_test
