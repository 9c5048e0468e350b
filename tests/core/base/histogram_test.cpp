#include "core/base/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace feltwire::histogram_test {
namespace {

TEST(Histogram, QuantilesAgreeWithSortedDataWithinTheStatedError) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(0.0, 39.0);  // Every octave is equally likely.
  std::vector<std::int64_t> data;
  Histogram histogram;
  double sum = 0.0;
  for (int i = 0; i < 100'000; ++i) {
    data.push_back(std::llround(std::exp2(exponent(random))));
    histogram.record(data.back());
    sum += static_cast<double>(data.back());
  }
  std::sort(data.begin(), data.end());
  for (const double q : {0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(data.size())));
    const auto exact = static_cast<double>(data[rank - 1]);
    EXPECT_NEAR(histogram.quantile(q), exact, exact / 256.0) << q;
  }
  EXPECT_EQ(histogram.max(), static_cast<std::uint64_t>(data.back()));
  EXPECT_EQ(histogram.count(), data.size());
  EXPECT_NEAR(histogram.mean(), sum / static_cast<double>(data.size()), 1e-6 * histogram.mean());
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram histogram;
  for (int i = 0; i < 256; ++i) histogram.record(i);
  for (int i = 1; i <= 256; ++i) EXPECT_EQ(histogram.quantile(i / 256.0), i - 1);
}

TEST(Histogram, EdgesStayInside) {
  Histogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0.0);
  histogram.record(-5);
  EXPECT_EQ(histogram.quantile(1.0), 0.0);
  histogram.record(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(histogram.max(), static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()));
  EXPECT_NEAR(histogram.quantile(1.0), std::exp2(40), std::exp2(40) / 256.0);  // the last bucket
}

}  // namespace
}  // namespace feltwire::histogram_test
