// Tests where scenes go.

#include "server/fleet/placement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/splitmix.hpp"

namespace feltwire::placement_test {
namespace {

using splitmix::draw;

HostRoom host(HostNumber number, std::vector<double> free_cores, bool draining = false) {
  return {number, std::move(free_cores), draining};
}

TEST(Placement, AScenesCostGrowsWithItsHands) {
  EXPECT_DOUBLE_EQ(scene_cost(50, 0.0092, 0.1).core_share, 0.56);
  EXPECT_DOUBLE_EQ(scene_cost(0, 0.0092, 0.1).core_share, 0.1);
}

TEST(Placement, ASceneNeedsRoomOnOneCore) {
  const HostRoom spread = host(1, {0.4, 0.4, 0.4});
  EXPECT_TRUE(fits(spread, {0.3}));
  EXPECT_FALSE(fits(spread, {0.31})) << "a tenth of each core stays free";
  EXPECT_FALSE(fits(host(1, {}), {0.0}));
  EXPECT_EQ(core_for(host(1, {1.0, 0.5, 0.3}), {0.35}), 1u) << "the fullest that has room";
  EXPECT_EQ(core_for(host(1, {1.0, 0.5, 0.3}), {0.95}), std::nullopt);
}

TEST(Placement, AHeartbeatTellsTheRoom) {
  HostRecord record;
  record.host = {"a", 7};
  record.free_shares = {100, 25, 255};
  record.draining = true;
  const HostRoom room = room_of(record);
  EXPECT_EQ(room.number, 7u);
  EXPECT_EQ(room.free_cores, (std::vector<double>{1.0, 0.25, 1.0}));
  EXPECT_TRUE(room.draining);
  EXPECT_DOUBLE_EQ(load(host(1, {1.0, 0.25})), 0.375);
  EXPECT_DOUBLE_EQ(load(host(1, {})), 1.0);
}

TEST(Placement, TheLessLoadedOfTwo) {
  const std::vector<HostRoom> hosts = {host(1, {0.5}), host(2, {0.9})};
  for (std::uint64_t seed = 0; seed < 100; ++seed) EXPECT_EQ(place(hosts, {0.1}, seed), 1u);
}

TEST(Placement, NoneThatDrainsIsFullOrIsExcluded) {
  const std::vector<HostRoom> hosts = {host(1, {1.0}, true), host(2, {0.1}), host(3, {1.0}),
                                       host(4, {1.0})};
  const HostNumber excluded[] = {4};
  for (std::uint64_t seed = 0; seed < 100; ++seed)
    EXPECT_EQ(place(hosts, {0.2}, seed, excluded), 2u);
  EXPECT_EQ(place(hosts, {0.95}, 0), std::nullopt);
  EXPECT_EQ(place({}, {0.1}, 0), std::nullopt);
}

/// Puts scenes of a tenth of a core on 100 hosts of four cores, and returns the highest load.
template <class Place>
double highest_load(const Place& choose) {
  std::vector<HostRoom> hosts;
  for (HostNumber number = 1; number <= 100; ++number)
    hosts.push_back(host(number, {1.0, 1.0, 1.0, 1.0}));
  const SceneCost cost{0.1};
  for (std::uint64_t scene = 0; scene < 1600; ++scene) {
    HostRoom& chosen = hosts[choose(hosts, cost, draw(1, scene))];
    chosen.free_cores[*core_for(chosen, cost)] -= cost.core_share;
  }
  return load(*std::ranges::max_element(hosts, {}, load));
}

TEST(Placement, TwoChoicesSpreadTheLoad) {
  using Hosts = std::vector<HostRoom>;
  const double two = highest_load([](const Hosts& hosts, const SceneCost& cost,
                                     std::uint64_t random) { return *place(hosts, cost, random); });
  const double one = highest_load([](const Hosts& hosts, const SceneCost&, std::uint64_t random) {
    return static_cast<std::size_t>(random % hosts.size());
  });
  EXPECT_LE(two, 0.40 + 0.06) << "the mean is 0.40";
  EXPECT_GE(one, two + 0.10) << "one choice is not enough";
}

TEST(Placement, EveryHostIsChosen) {
  const std::vector<HostRoom> hosts(7, host(1, {1.0}));
  std::vector<int> chosen(hosts.size());
  for (std::uint64_t i = 0; i < 7000; ++i) ++chosen[*place(hosts, {0.1}, draw(2, i))];
  for (const int count : chosen) EXPECT_NEAR(count, 1000, 150);
}

TEST(Placement, AMoveNeedsAGain) {
  std::vector<HostRoom> hosts = {host(1, {0.2, 0.2}), host(2, {0.5, 0.5})};
  const std::vector<PlacedScene> scenes = {{{0.2}, 0}};
  // Loads 0.8 and 0.5 become 0.7 and 0.6.
  const auto move = next_move(hosts, 0, scenes, 1);
  ASSERT_TRUE(move);
  EXPECT_EQ(move->scene, 0u);
  EXPECT_EQ(move->to, 1u);
  hosts[1].free_cores = {0.45, 0.5};
  EXPECT_FALSE(next_move(hosts, 0, scenes, 1)) << "loads 0.7 and 0.625: not worth it";
  hosts[0].draining = true;
  EXPECT_TRUE(next_move(hosts, 0, scenes, 1)) << "a host that drains gives all it has";
  EXPECT_FALSE(next_move(hosts, 0, {}, 1));
}

TEST(Placement, AnOverfullCoreGivesAScene) {
  const std::vector<HostRoom> hosts = {host(1, {0.05, 0.5}), host(2, {0.5, 0.5})};
  EXPECT_TRUE(overfull(hosts[0], 0));
  EXPECT_FALSE(overfull(hosts[0], 1));
  EXPECT_FALSE(overfull(host(1, {0.1}), 0));
  const std::vector<PlacedScene> scenes = {{{0.3}, 1}, {{0.3}, 0}};
  const auto move = next_move(hosts, 0, scenes, 1);
  ASSERT_TRUE(move);
  EXPECT_EQ(move->scene, 1u) << "not that of the other core, which gains nothing";
}

/// Moves until nothing is worth it: it ends, and evenly.
TEST(Placement, RebalancingEnds) {
  std::vector<HostRoom> hosts;
  for (HostNumber number = 1; number <= 10; ++number) hosts.push_back(host(number, {1.0, 1.0}));
  std::vector<std::vector<PlacedScene>> scenes(hosts.size());
  const auto put = [&](std::size_t at, const SceneCost& cost) {
    const std::size_t core = *core_for(hosts[at], cost);
    hosts[at].free_cores[core] -= cost.core_share;
    scenes[at].push_back({cost, core});
  };
  for (int i = 0; i < 16; ++i) put(static_cast<std::size_t>(i % 2), {0.1});
  int moves = 0;
  for (bool moved = true; moved;) {
    moved = false;
    for (std::size_t from = 0; from < hosts.size(); ++from) {
      const auto move = next_move(hosts, from, scenes[from], draw(3, moves));
      if (!move) continue;
      const PlacedScene scene = scenes[from][move->scene];
      scenes[from].erase(scenes[from].begin() + static_cast<std::ptrdiff_t>(move->scene));
      hosts[from].free_cores[scene.core] += scene.cost.core_share;
      put(move->to, scene.cost);
      moved = true;
      ASSERT_LT(++moves, 100) << "scenes move for ever";
    }
  }
  EXPECT_GE(moves, 8);
  EXPECT_LE(load(*std::ranges::max_element(hosts, {}, load)), 0.2);
}

}  // namespace
}  // namespace feltwire::placement_test
