#include "core/bounding/hold_reserve.hpp"

#include <gtest/gtest.h>

namespace feltwire::hold_reserve_test {
namespace {

TEST(HoldReserve, IsThePeriodWhereTicksAreExact) {
  HoldReserve reserve(1e-3);
  for (int i = 0; i < 5000; ++i) {
    reserve.saw(i % 2 == 0 ? 1e-3 : 0.2e-3);
    EXPECT_EQ(reserve.hold_time(), 1e-3);
  }
}

TEST(HoldReserve, ReckonsWithTwiceTheLatestOfTheLastSecondsAndAtMostOnePeriodMore) {
  HoldReserve reserve(1e-3);
  reserve.saw(1.1e-3);
  EXPECT_NEAR(reserve.hold_time(), 1.2e-3, 1e-15);
  for (int i = 0; i < 900; ++i) reserve.saw(1e-3);
  EXPECT_NEAR(reserve.hold_time(), 1.2e-3, 1e-15);
  for (int i = 0; i < 2200; ++i) reserve.saw(1e-3);  // forgotten
  EXPECT_EQ(reserve.hold_time(), 1e-3);
  reserve.saw(0.7);
  EXPECT_EQ(reserve.hold_time(), 2e-3);
}

}  // namespace
}  // namespace feltwire::hold_reserve_test
