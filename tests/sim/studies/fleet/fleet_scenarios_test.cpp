// Tests the simulated fleet with a fiftieth of the study's scenes.

#include "sim/studies/fleet/fleet_scenarios.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace feltwire::fleet_scenarios_test {
namespace {

using namespace fleet;

constexpr std::uint32_t kHosts = 40;

FleetInputs small() {
  FleetInputs inputs;
  inputs.scenes = 200;
  inputs.cores = 6;
  return inputs;
}

TEST(Fleet, HasTheFewestHostsThatHoldAllScenes) {
  const std::uint32_t least = least_hosts(small());
  EXPECT_LT(least, kHosts);
  EXPECT_TRUE(VirtualFleet(small(), least).place_all());
  EXPECT_FALSE(VirtualFleet(small(), least - 1).place_all());
  EXPECT_THROW(lose_rack(small(), least - 1, false), std::runtime_error);
}

TEST(Fleet, IsWholeAgainAfterARackIsLost) {
  const FleetRun run = lose_rack(small(), kHosts, false);
  EXPECT_TRUE(run.finished);
  EXPECT_GT(run.hands, 300u);
  EXPECT_GT(run.counts.takeovers, 3u);
  EXPECT_EQ(run.counts.joins, run.hands);
  EXPECT_GE(run.counts.without_session.quantile(0.0), 2e6) << "before anybody noticed";
  EXPECT_GT(run.rebalanced, 2.0);
  EXPECT_LT(run.rebalanced, 60.0);
  EXPECT_EQ(run.counts.lower_epochs, 0u);
}

TEST(Fleet, GivesTheSameNumbersEachTime) {
  const FleetRun first = lose_rack(small(), kHosts, false),
                 second = lose_rack(small(), kHosts, false);
  EXPECT_EQ(first.rebalanced, second.rebalanced);
  EXPECT_EQ(first.counts.bytes, second.counts.bytes);
  FleetInputs other = small();
  other.seed = 77;
  EXPECT_NE(lose_rack(other, kHosts, false).rebalanced, first.rebalanced);
}

/// Standbys serve without a write: hands are back long before the directory is.
TEST(Fleet, HandsWaitForNoDirectory) {
  FleetInputs inputs = small();
  inputs.leader_loss = 200.0;
  const FleetRun run = lose_rack(inputs, kHosts, true);
  EXPECT_TRUE(run.finished);
  EXPECT_LT(run.last_hand, 60.0);
  EXPECT_GT(run.rebalanced, 200.0);
}

TEST(Fleet, JoinsDoNotFeelThatTheDirectoryIsGone) {
  const FleetRun run = lose_leader(small(), kHosts);
  EXPECT_TRUE(run.finished);
  EXPECT_EQ(run.counts.takeovers, 0u);
  EXPECT_LT(run.counts.without_session.quantile(0.99), 1e6);
}

TEST(Fleet, ScenesInTwoRoomsComeTogetherAfterAPartition) {
  FleetInputs inputs = small();
  inputs.partition = 40.0;
  const FleetRun run = partition(inputs, kHosts);
  EXPECT_TRUE(run.finished);
  EXPECT_GT(run.counts.takeovers, 3u);
  EXPECT_EQ(run.notes.front().first, "scenes in two rooms meanwhile");
  EXPECT_GT(std::stoi(run.notes.front().second), 3);
  EXPECT_GT(run.last_hand, inputs.partition) << "the former owners' hands move at its end";
}

TEST(Fleet, EveryHostRestartsAndEveryHandComesBack) {
  const FleetRun run = restart_all(small(), kHosts);
  EXPECT_TRUE(run.finished);
  EXPECT_GE(run.counts.moves, 200u) << "each scene moves at least once";
  EXPECT_GE(run.hands, 200u * 30u);
  EXPECT_LT(run.counts.without_session.quantile(0.5), 2e6);
}

TEST(Fleet, AHostTakesItsJoinsOneByOne) {
  FleetInputs inputs = small();
  const FleetRun fast = everybody_joins(inputs, kHosts);
  inputs.join_time *= 50.0;  // 100 ms: ten joins a second of a host
  const FleetRun slow = everybody_joins(inputs, kHosts);
  EXPECT_TRUE(fast.finished && slow.finished);
  EXPECT_LE(slow.counts.joins_by_second.peak(), 1.2 * kHosts * 10.0);
  EXPECT_GT(slow.last_hand, fast.last_hand);
}

TEST(Fleet, TheTableNamesEveryRun) {
  FleetStudy study;
  study.runs = {lose_rack(small(), kHosts, false)};
  const std::string table = fleet_table(study);
  EXPECT_NE(table.find("rack lost"), std::string::npos);
  EXPECT_NE(table.find("all is well again"), std::string::npos);
  study.runs.front().finished = false;
  EXPECT_NE(fleet_table(study).find("NOT finished"), std::string::npos);
}

}  // namespace
}  // namespace feltwire::fleet_scenarios_test
