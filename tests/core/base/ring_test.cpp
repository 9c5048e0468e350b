#include "core/base/ring.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

#include "tests/support/eventually.hpp"

namespace feltwire::ring_test {
namespace {

TEST(Ring, FullRefusesAndNothingIsLostOrReordered) {
  Ring<int> ring(3);  // The capacity is rounded up to 4.
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

/// A value that clears itself in its destructor.
struct Key {
  explicit Key(int given = 0) : secret(given) {}
  Key(const Key&) = default;
  Key& operator=(const Key& other) {
    if (secret != 0 && other.secret == 0) ++wiped;
    secret = other.secret;
    return *this;
  }
  ~Key() { secret = 0; }
  int secret;
  static inline int wiped = 0;
};

TEST(Ring, WhatWipesItselfIsNotLeftInItsPlace) {
  Ring<Key> ring(4);
  for (int i = 1; i <= 3; ++i) ring.push(Key(i));
  Key taken;
  EXPECT_TRUE(ring.pop(taken));
  EXPECT_EQ(taken.secret, 1);
  EXPECT_EQ(Key::wiped, 1);
  EXPECT_TRUE(ring.pop(taken));
  EXPECT_EQ(Key::wiped, 2);
}

TEST(Ring, OneThreadWritesAnotherReads) {
  struct Pair {
    std::uint64_t a = 0, b = 0;
  };
  Ring<Pair> ring(64);
  constexpr std::uint64_t kCount = 100'000;
  std::jthread writer([&](const std::stop_token& stop) {
    for (std::uint64_t i = 1; i <= kCount && !stop.stop_requested();) {
      if (ring.push({i, ~i})) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  Pair pair;
  for (std::uint64_t expected = 1; expected <= kCount; ++expected) {
    test::eventually("the next pair", [&] { return ring.pop(pair); });
    ASSERT_EQ(pair.a, expected);
    ASSERT_EQ(pair.b, ~expected);
  }
  EXPECT_FALSE(ring.pop(pair));
}

}  // namespace
}  // namespace feltwire::ring_test
