// Tests counts of times by class.

#include "core/base/time_counts.hpp"

#include <gtest/gtest.h>

namespace feltwire {
namespace {

TEST(TimeCounts, ALimitBelongsToItsClass) {
  TimeCounts times;
  for (std::size_t i = 0; i < TimeCounts::kLimits.size(); ++i) {
    times.record(TimeCounts::kLimits[i]);
    EXPECT_EQ(times.counts()[i], 1u);
    times.record(TimeCounts::kLimits[i] + 1, 2);
    EXPECT_EQ(times.counts()[i + 1], 2u);
    times = {};
  }
  times.record(-5);
  EXPECT_EQ(times.counts()[0], 1u);
  EXPECT_EQ(times.sum(), 0u);
}

TEST(TimeCounts, TheSumIsExact) {
  TimeCounts times;
  times.record(123'456'789, 3);
  times.record(1);
  EXPECT_EQ(times.sum(), 370'370'368u);
}

}  // namespace
}  // namespace feltwire
