// A tree over boxes must find every box, for each way of building.

#include "core/mesh/box_tree.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/base/splitmix.hpp"

namespace feltwire::box_tree_test {
namespace {

/// Returns the i-th random value from -1 to 1.
double draw(std::uint64_t i) {
  return static_cast<double>(splitmix::draw(5, i) >> 11) * 0x1p-52 - 1.0;
}

Vec3 place(std::uint64_t i) { return {draw(3 * i), draw(3 * i + 1), draw(3 * i + 2)}; }

/// Returns boxes with sizes over four orders of magnitude. Many boxes have a common position.
std::vector<Bounds> boxes(std::size_t count) {
  std::vector<Bounds> all(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double size = i % 1000 == 0 ? 0.5 : 1e-4 + 1e-3 * std::abs(draw(7'000'000 + i));
    const Vec3 middle = i % 10 == 0 ? Vec3::Zero() : place(i);
    all[i].add(middle - Vec3::Constant(size));
    all[i].add(middle + Vec3::Constant(size));
  }
  return all;
}

TEST(BoxTree, BoxesBeyondItsReachAreRefused) {
  for (const double far : {1e19, 1e300, std::numeric_limits<double>::infinity(), std::nan("")}) {
    std::vector<Bounds> boxes(3);
    for (Bounds& box : boxes) box = {Vec3::Zero(), Vec3::Ones()};
    boxes[1].most.y() = far;
    EXPECT_THROW(BoxTree{boxes}, std::invalid_argument) << far;
    boxes[1] = {Vec3(0, -far, 0), Vec3::Ones()};
    EXPECT_THROW(BoxTree{boxes}, std::invalid_argument) << far;
  }
}

TEST(BoxTree, FewAndManyMissNone) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{1000}, std::size_t{1} << 18}) {
    const auto all = boxes(count);
    const BoxTree tree(all);
    for (std::uint64_t q = 0; q < 12; ++q) {
      const Vec3 at = q == 0 ? Vec3::Zero() : place(9'000'000 + q);
      Bounds asked;
      asked.add(at - Vec3::Constant(0.01));
      asked.add(at + Vec3::Constant(0.02));
      std::vector<int> visits(count);
      tree.overlapping(asked, [&](std::uint32_t i) { ++visits[i]; });
      for (std::size_t i = 0; i < count; ++i) {
        ASSERT_LE(visits[i], 1);
        ASSERT_GE(visits[i], all[i].overlaps(asked) ? 1 : 0) << count << " " << i;
      }
    }
  }
}

/// Each box is half as far away as the previous box, so every split separates a single box. The
/// tree must not become too deep for the stack of a query.
TEST(BoxTree, ThingsThatCrowdTowardsAPlaceMakeNoDeepTree) {
  constexpr std::size_t kCount = 20000;
  std::vector<Bounds> all(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double at = 1e18 * std::pow(0.5, 180.0 * static_cast<double>(i) / kCount);
    all[i].add(Vec3(at, 0, 0));
    all[i].add(Vec3(at, 1e-30, 0));
  }
  const BoxTree tree(all);
  Bounds everything;
  everything.add(Vec3::Constant(-1e18));
  everything.add(Vec3::Constant(1e18));
  std::vector<int> visits(kCount);
  tree.overlapping(everything, [&](std::uint32_t i) { ++visits[i]; });
  tree.within(
      Vec3::Zero(), [] { return 2e18; }, [&](std::uint32_t i) { ++visits[i]; });
  EXPECT_TRUE(std::ranges::all_of(visits, [](int n) { return n == 2; }));
}

TEST(BoxTree, TheSameBoxesGiveTheSameOrderOfVisits) {
  const auto all = boxes(3000);
  std::array<std::vector<std::uint32_t>, 2> order;
  for (auto& visited : order) {
    const BoxTree tree(all);
    tree.within(
        Vec3::Zero(), [] { return 10.0; }, [&](std::uint32_t i) { visited.push_back(i); });
  }
  EXPECT_EQ(order[0].size(), all.size());
  EXPECT_EQ(order[0], order[1]);
}

std::vector<std::uint32_t> visits(const BoxTree& tree) {
  Bounds everywhere;
  everywhere.add(Vec3::Constant(-2.0));
  everywhere.add(Vec3::Constant(2.0));
  std::vector<std::uint32_t> order;
  tree.overlapping(everywhere, [&](std::uint32_t i) { order.push_back(i); });
  return order;
}

TEST(BoxTree, OneCoreBuildsTheSameTreeAsAll) {
  const auto all = boxes(150'000);
  cpu_set_t cores, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof cores, &cores), 0);
  const auto by_all = visits(BoxTree(all));
  CPU_ZERO(&one);
  for (int core = 0; core < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++core)
    if (CPU_ISSET(core, &cores)) CPU_SET(core, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  const auto by_one = visits(BoxTree(all));
  ASSERT_EQ(sched_setaffinity(0, sizeof cores, &cores), 0);
  EXPECT_EQ(by_all.size(), all.size());
  EXPECT_EQ(by_one, by_all);
}

}  // namespace
}  // namespace feltwire::box_tree_test
