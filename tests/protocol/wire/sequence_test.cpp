#include "protocol/wire/sequence.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>

namespace feltwire::sequence_test {
namespace {

/// Returns true for a fresh number, and only once.
bool take(PacketWindow& window, std::uint64_t number) {
  if (!window.fresh(number)) return false;
  window.mark(number);
  return true;
}

TEST(PacketWindow, EachNumberOnce) {
  PacketWindow window;
  EXPECT_FALSE(take(window, 0));
  EXPECT_TRUE(take(window, 1));
  EXPECT_FALSE(take(window, 1));
  EXPECT_TRUE(take(window, 3));
  EXPECT_TRUE(take(window, 2));  // late, but not lost
  EXPECT_FALSE(take(window, 2));
  EXPECT_EQ(window.highest(), 3u);
}

TEST(PacketWindow, AskingMarksNothing) {
  PacketWindow window;
  EXPECT_TRUE(window.fresh(1'000'000));
  EXPECT_TRUE(window.fresh(1'000'000));
  EXPECT_EQ(window.highest(), 0u);
  EXPECT_TRUE(take(window, 1));
}

TEST(PacketWindow, EdgeOfTheWindow) {
  PacketWindow window;
  EXPECT_TRUE(take(window, PacketWindow::kWidth + 5));
  EXPECT_FALSE(take(window, 5));  // a number that is kWidth below the highest number and too old
  EXPECT_TRUE(take(window, 6));
}

TEST(PacketWindow, UpToTheLastNumber) {
  constexpr auto last = std::numeric_limits<std::uint64_t>::max();
  PacketWindow window;
  EXPECT_TRUE(take(window, last - 1));
  EXPECT_TRUE(take(window, last));
  EXPECT_FALSE(take(window, last));
  EXPECT_FALSE(take(window, 0));
  EXPECT_FALSE(take(window, 1));
  EXPECT_TRUE(take(window, last - PacketWindow::kWidth + 1));
  EXPECT_FALSE(take(window, last - PacketWindow::kWidth));
}

/// Compares the window with a simple set, with reordering, repeats and jumps of all sizes.
TEST(PacketWindow, MatchesASetOfAllSeen) {
  std::mt19937_64 random(7);
  for (int round = 0; round < 20; ++round) {
    PacketWindow window;
    std::set<std::uint64_t> seen;
    std::uint64_t highest = 0, base = 1 + (random() % 3) * 1'000'000;
    for (int step = 0; step < 20'000; ++step) {
      const std::uint64_t kind = random() % 100;
      std::uint64_t number = base;
      if (kind < 60)
        number = ++base;  // in order
      else if (kind < 90)
        number = base > 1500 ? base - random() % 1500 : 1 + random() % (base + 1);
      else if (kind < 99)
        number = base += random() % 50;
      else
        number = base += random() % 3000;
      const bool expected = number != 0 && !seen.contains(number) &&
                            (number > highest || highest - number < PacketWindow::kWidth);
      ASSERT_EQ(take(window, number), expected) << "number " << number << " highest " << highest;
      if (expected) seen.insert(number);
      highest = std::max(highest, number);
      ASSERT_EQ(window.highest(), highest);
    }
  }
}

}  // namespace
}  // namespace feltwire::sequence_test
