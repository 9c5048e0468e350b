// Tries every order of the steps of three hosts, a client and a directory that loses writes and
// answers stale, late and twice. The search is exhaustive within its bounds.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/base/splitmix.hpp"
#include "tests/server/fleet/fleet_model.hpp"

namespace feltwire::ownership_search_test {
namespace {

using test::Bounds;
using test::FleetModel;
using test::Rules;

struct Found {
  std::string violation;  // empty: no rule is broken
  std::string steps;      // one line each
  std::size_t states = 0;
};

/// 64 bits of two states are equal with a probability of about states^2 / 2^65.
std::uint64_t hash(const std::vector<std::uint64_t>& numbers) {
  std::uint64_t mixed = numbers.size();
  for (const std::uint64_t number : numbers)
    mixed = splitmix::mix(mixed ^ (number + splitmix::kStep));
  return mixed;
}

enum class Look { at_rules, also_at_the_end };

/// Searches all states within the bounds, depth first, which needs no memory for the states that
/// are still to be tried. Also at the end: from each state all must come right once the lies end.
class Search {
 public:
  Search(const Rules& rules, const Bounds& bounds, Look look) : rules_(rules), look_(look) {
    const FleetModel start(rules, bounds);
    seen_.insert(hash(start.key()));
    visit(start);
    found_.states = seen_.size();
  }
  const Found& found() const { return found_; }

 private:
  bool done() const { return !found_.violation.empty(); }

  void explain(const std::string& violation) {
    if (violation.empty() || done()) return;
    found_.violation = violation;
    for (const std::string& step : path_) found_.steps += step + "\n";
  }

  void visit(const FleetModel& model) {
    explain(model.violation());
    if (!done() && look_ == Look::also_at_the_end) explain(model.settle(rules_));
    if (done()) return;
    model.for_each_step(rules_, [&](FleetModel&& next, std::string step) {
      if (done() || !seen_.insert(hash(next.key())).second) return;
      path_.push_back(std::move(step));
      visit(next);
      path_.pop_back();
    });
  }

  const Rules rules_;
  const Look look_;
  std::unordered_set<std::uint64_t> seen_;
  std::vector<std::string> path_;
  Found found_;
};

// Each has what the others leave out; all at once would take hours. The order: hosts, claims,
// takeovers, reservations, writes, losses, restarts, joins, handovers.
constexpr Bounds kToldAfterwards{3, 1, 1, 1, 1, 1, 0, 1}, kTwoClaims{2, 2, 1, 1, 1, 1, 0, 1},
    kThreeHosts{3, 2, 1, 1, 1, 0, 0, 0}, kThereAndBack{2, 1, 2, 2, 3, 1, 0, 1},
    kRestart{2, 2, 0, 0, 0, 1, 1, 2}, kHandedOver{2, 2, 0, 0, 1, 0, 0, 1, 1},
    kHandedBack{2, 1, 1, 0, 2, 1, 0, 1, 2}, kHandedToTheDead{2, 2, 0, 0, 1, 1, 1, 0, 1},
    kHandedToAThird{3, 1, 1, 1, 1, 0, 0, 1, 1};

/// Bounds, and the number of states that they give.
struct Case {
  Bounds bounds;
  std::size_t least_states = 0;
};
class EveryLie : public ::testing::TestWithParam<Case> {};

TEST_P(EveryLie, LeavesTheRulesWhole) {
  const auto& [bounds, least_states] = GetParam();
  const Found found = Search({}, bounds, Look::also_at_the_end).found();
  EXPECT_EQ(found.violation, "") << found.steps;
  EXPECT_GE(found.states, least_states) << "the search became shallow";
}

// The sanitizers look at the functions of the product, for which one search is enough.
#ifdef FELTWIRE_SANITIZED
const auto kCases = ::testing::Values(Case{kToldAfterwards, 40'000});
#else
const auto kCases = ::testing::Values(
    Case{kToldAfterwards, 40'000}, Case{kTwoClaims, 200'000}, Case{kThreeHosts, 100'000},
    Case{kThereAndBack, 200'000}, Case{kRestart, 300'000}, Case{kHandedOver, 60'000},
    Case{kHandedBack, 50'000}, Case{kHandedToTheDead, 200'000}, Case{kHandedToAThird, 140'000});
#endif
INSTANTIATE_TEST_SUITE_P(OwnershipSearch, EveryLie, kCases);

// Each mutant breaks one rule of the product, and the search must find a way to what follows.

std::string found(const Rules& mutant, const Bounds& bounds, Look look = Look::at_rules) {
  return Search(mutant, bounds, look).found().violation;
}

constexpr const char* kClientBelow = "the client has a session below an epoch that it has seen";
constexpr const char* kTwoAccept = "two processes accept at one epoch";
constexpr const char* kHostBelow = "a host serves below an epoch that it has seen";
constexpr const char* kTwoForEver = "2 hosts serve the scene for ever";

TEST(OwnershipSearch, AClientThatTakesAnySession) {
  Rules mutant;
  mutant.take_session = [](SessionEpoch& known, const Epoch& offered) {
    known.highest = std::max(known.highest, offered);
    known.session = offered;
    return true;
  };
  EXPECT_EQ(found(mutant, kTwoClaims), kClientBelow);
}

TEST(OwnershipSearch, AClientThatStaysWithAFormerOwner) {
  Rules mutant;
  mutant.hear_epoch = [](SessionEpoch& known, const Epoch& heard) {
    return admit(known.highest, heard);
  };
  EXPECT_EQ(found(mutant, kTwoClaims), kClientBelow);
}

TEST(OwnershipSearch, AClientThatForgetsWhatItHears) {
  Rules mutant;
  mutant.hear_epoch = [](SessionEpoch&, const Epoch&) { return false; };
  EXPECT_EQ(found(mutant, kTwoClaims), kClientBelow);
}

TEST(OwnershipSearch, EpochsThatAreMereCounters) {
  Rules mutant;
  mutant.numbers_differ = false;
  EXPECT_EQ(found(mutant, kRestart), kTwoAccept);
}

/// A mere counter fails even with a directory that loses nothing: one host claims the epoch that
/// the standby was promised.
TEST(OwnershipSearch, EpochsThatAreMereCountersWithAnHonestDirectory) {
  Rules mutant;
  mutant.numbers_differ = false;
  EXPECT_EQ(found(mutant, {3, 2, 1, 1, 1, 0, 0, 2}), kTwoAccept);
}

TEST(OwnershipSearch, AHostThatKeepsItsNumberWhenItStartsAgain) {
  Rules mutant;
  mutant.number_is_new = false;
  EXPECT_EQ(found(mutant, kRestart), kTwoAccept);
}

TEST(OwnershipSearch, AStandbyThatIgnoresALaterOwner) {
  Rules mutant;
  mutant.take_over = [](SceneOwnership& scene, const HostName& self) {
    SceneOwnership blind = scene;
    blind.highest = {};
    if (!take_over(blind, self)) return false;
    blind.highest = std::max(blind.highest, scene.highest);
    scene = blind;
    return true;
  };
  EXPECT_EQ(found(mutant, kThreeHosts), kHostBelow);
}

TEST(OwnershipSearch, AnOwnerThatDoesNotLetGo) {
  Rules mutant;
  mutant.see_record = [](SceneOwnership& scene, const SceneRecord& record, std::uint64_t revision) {
    const auto serving = scene.serving;
    see_record(scene, record, revision);
    scene.serving = serving;
    return false;
  };
  EXPECT_EQ(found(mutant, kTwoClaims), kHostBelow);
}

TEST(OwnershipSearch, AClaimThatIsServedAlthoughALaterOwnerIsKnown) {
  Rules mutant;
  mutant.finish_claim = [](SceneOwnership& scene, const SceneRecord& claimed,
                           std::uint64_t revision) {
    finish_claim(scene, claimed, revision);
    scene.serving = claimed.version.epoch;
    return true;
  };
  EXPECT_EQ(found(mutant, kTwoClaims), kHostBelow);
}

TEST(OwnershipSearch, AHostThatAcceptsAClientWhichKnowsMore) {
  Rules mutant;
  mutant.answer_join = [](const SceneOwnership& scene, const Epoch&) {
    return answer_join(scene, {});
  };
  EXPECT_EQ(found(mutant, kTwoClaims), "a host accepts a client that has seen a higher epoch");
}

TEST(OwnershipSearch, AStandbyThatTakesOverAndTellsNobody) {
  Rules mutant;
  mutant.record_to_write = [](const SceneOwnership& scene) {
    const auto record = record_to_write(scene);
    return record && record->standby.number != 0 ? record : std::nullopt;
  };
  EXPECT_EQ(found(mutant, kToldAfterwards, Look::also_at_the_end), kTwoForEver);
}

TEST(OwnershipSearch, AnOwnerThatTakesJoinsUntilTheNextOneServes) {
  Rules mutant;
  mutant.hand_over = [](SceneOwnership& scene, const HostName& target) {
    const auto serving = scene.serving;
    hand_over(scene, target);
    scene.serving = serving;
    scene.leaving.reset();
  };
  EXPECT_EQ(found(mutant, kHandedOver),
            "a former owner takes joins beside the host that has the scene from it");
}

TEST(OwnershipSearch, AFormerOwnerThatForgetsItsSessions) {
  Rules mutant;
  mutant.hand_over = [](SceneOwnership& scene, const HostName& target) {
    hand_over(scene, target);
    scene.leaving.reset();
  };
  EXPECT_EQ(found(mutant, kHandedOver, Look::also_at_the_end),
            "sessions of a former owner go on for ever");
}

}  // namespace
}  // namespace feltwire::ownership_search_test
