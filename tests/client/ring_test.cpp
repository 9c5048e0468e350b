#include "client/ring.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace feltwire::ring_test {
namespace {

TEST(Ring, FullRefusesAndNothingIsLostOrReordered) {
  Ring<int> ring(3);  // rounded up to 4
  int value = 0;
  EXPECT_FALSE(ring.pop(value));
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(i));
    EXPECT_FALSE(ring.push(99));
    for (int i = 0; i < 4; ++i) {
      EXPECT_TRUE(ring.pop(value));
      EXPECT_EQ(value, i);
    }
    EXPECT_FALSE(ring.pop(value));
  }
}

TEST(Ring, OneThreadWritesAnotherReads) {
  struct Pair {
    std::uint64_t a = 0, b = 0;
  };
  Ring<Pair> ring(64);
  constexpr std::uint64_t kCount = 100'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kCount;) {
      if (ring.push({i, ~i})) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  Pair pair;
  for (std::uint64_t expected = 1; expected <= kCount;) {
    if (!ring.pop(pair)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(pair.a, expected);
    ASSERT_EQ(pair.b, ~expected);
    ++expected;
  }
  writer.join();
}

}  // namespace
}  // namespace feltwire::ring_test
