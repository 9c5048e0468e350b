#include "server/scene/id_map.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace feltwire::id_map_test {
namespace {

/// Compares IdMap with std::map, with colliding ids.
TEST(IdMap, MatchesAMap) {
  std::mt19937_64 random(5);
  for (const std::size_t capacity : {1u, 2u, 7u, 64u}) {
    IdMap<int> map(capacity);
    std::map<std::uint64_t, int> expected;
    for (int step = 0; step < 20'000; ++step) {
      const std::uint64_t id = (random() % (3 * capacity)) << (random() % 2 ? 8 : 12) | 5;
      if (random() % 2) {
        if (expected.size() < capacity) {
          ASSERT_EQ(map.insert(id, step), expected.emplace(id, step).second);
        }
      } else {
        ASSERT_EQ(map.erase(id), expected.erase(id) == 1);
      }
      ASSERT_EQ(map.size(), expected.size());
      for (const auto& [known, value] : expected) {
        int* found = map.find(known);
        ASSERT_NE(found, nullptr);
        ASSERT_EQ(*found, value);
      }
      ASSERT_EQ(map.find(random() | 1ull << 63), nullptr);
    }
  }
}

TEST(IdMap, ZeroIsNoId) {
  IdMap<int> map(3);
  EXPECT_FALSE(map.insert(0, 1));
  EXPECT_FALSE(map.erase(0));
  EXPECT_EQ(map.find(0), nullptr);
}

}  // namespace
}  // namespace feltwire::id_map_test
