#include "sim/measure/experiment_metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace feltwire::metrics_test {
namespace {

TEST(Metrics, HighpassOfAFastSineIsItsRmsAndOfASlowLineIsNothing) {
  std::vector<double> fast, line;
  // 51 samples are exactly 3 periods of 17. The moving average of the sine is then zero.
  for (int n = 0; n < 4000; ++n) {
    fast.push_back(5.0 + 2.0 * std::sin(2.0 * std::numbers::pi * n / 17.0));
    line.push_back(1e6 + 0.25 * n);
  }
  EXPECT_NEAR(highpass_rms(fast, 1e3), 2.0 / std::sqrt(2.0), 1e-3);
  EXPECT_NEAR(highpass_rms(line, 1e3), 0.0, 1e-9);
}

TEST(Metrics, HighpassLooksAtTheSecondHalfOnly) {
  std::vector<double> values(4000, 0.0);
  for (std::size_t n = 0; n < 1900; ++n) values[n] = n % 2 == 0 ? 1.0 : -1.0;
  EXPECT_EQ(highpass_rms(values, 1e3), 0.0);
}

TEST(Metrics, MedianIsTheMiddleOrTheMeanOfTheTwoInIt) {
  EXPECT_EQ(median({}), 0.0);
  EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 3.0, 2.0}), 2.5);
}

TEST(Metrics, SpreadIsMeanNearestRankAndMaximum) {
  std::vector<double> values;
  for (int i = 200; i >= 1; --i) values.push_back(i);
  const Spread s = spread(values);
  EXPECT_DOUBLE_EQ(s.mean, 100.5);
  EXPECT_DOUBLE_EQ(s.p99, 198.0);
  EXPECT_DOUBLE_EQ(s.max, 200.0);
  EXPECT_EQ(spread({}).max, 0.0);
}

/// Returns three samples along x: 1 mm inwards without force, 1 mm inwards under -2 N, and 1 mm
/// outwards under -4 N.
std::vector<ExperimentSample> three_samples() {
  std::vector<ExperimentSample> s(3);
  const double dx[] = {1e-3, 1e-3, -1e-3}, rendered[] = {-2.0, -4.0, -2.0},
               held[] = {0.0, -2.0, -4.0};
  for (std::size_t n = 0; n < 3; ++n) {
    s[n].displacement.x() = dx[n];
    s[n].commanded.elastic.x() = -4.0;
    s[n].rendered.elastic.x() = rendered[n];
    s[n].held.x() = held[n];
  }
  return s;
}

TEST(Metrics, EnergyIsCountedBothWays) {
  const ExperimentMetrics m = measure(three_samples(), {0.0, 0.0}, 0.0, 1e-3);
  // With the new force as in the methods: 2 + 4 - 2 mJ. With the held force at the port: 0 + 2 - 4
  // mJ.
  EXPECT_NEAR(m.total_energy, 4e-3, 1e-15);
  EXPECT_NEAR(m.min_energy.x(), 0.0, 1e-15);
  EXPECT_NEAR(m.port_energy, -2e-3, 1e-15);
  EXPECT_NEAR(m.min_port_energy.x(), -2e-3, 1e-15);
  EXPECT_NEAR(m.min_port_margin, -2e-3, 1e-15);
  EXPECT_NEAR(m.force_ratio, (0.5 + 1.0 + 0.5) / 3.0, 1e-15);
}

TEST(Metrics, OutsideTheAxisBoundsIsCountedByTheirInterval) {
  const auto share = [](double c) {
    return measure(three_samples(), {c, c}, 0.0, 1e-3).outside_bounds_share;
  };
  EXPECT_EQ(share(2000.0), 0.0) << "each change is exactly c1 dx";
  EXPECT_EQ(share(1000.0), 1.0) << "each change is twice what c1 allows";
  EXPECT_NEAR(share(4000.0), 1.0 / 3.0, 1e-15)
      << "a stiffer storage holds less: on the way out 2 N is above 16 / (4 + sqrt(32)) N";
}

TEST(Metrics, DirectionErrorIsTheAngle) {
  std::vector<ExperimentSample> s(1);
  s[0].commanded.elastic = {1.0, 0.0, 0.0};
  s[0].rendered.elastic = {2.0, 2.0, 0.0};
  EXPECT_NEAR(measure(s, {1.0, 1.0}, 0.0, 1e-3).direction_error.mean, std::numbers::pi / 4.0,
              1e-12);
}

}  // namespace
}  // namespace feltwire::metrics_test
