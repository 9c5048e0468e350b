// The path that an encoder certainly shows is never longer than the true one, and not much shorter
// where it goes straight on.

#include "core/bounding/certain_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/support.hpp"

namespace feltwire::certain_path_test {
namespace {

using namespace test;

Vec3 encoded(const Vec3& place, double quantum) {
  return quantum > 0.0 ? Vec3((place / quantum).array().round().matrix() * quantum) : place;
}

/// Straight on, to and fro within some quanta, round curves, and across edges of the encoder.
TEST(CertainPath, IsNeverLongerThanTheTrueOneAfterAnyNumberOfSamples) {
  Random random(5);
  for (int walk = 0; walk < 300; ++walk) {
    const double q = random.chance(0.9) ? std::abs(random.decades(-6.0, -4.0)) : 0.0;
    const double stride = std::abs(random.decades(-7.0, -3.0));
    const double turning = random.uniform(0.0, 1.0);
    CertainPath certain(q);
    Vec3 place = random.vector(-3.0, -2.0), shown = encoded(place, q), way = random.direction();
    double path = 0.0, counted = 0.0;
    for (int n = 0; n < 3000; ++n) {
      for (int i = 0; i < 4; ++i) {
        if (random.chance(0.1)) way = -way;
        way = (way + turning * random.direction()).normalized();
        const Vec3 step = stride * random.uniform(0.0, 1.0) * way;
        place += step;
        path += step.norm();
      }
      const Vec3 now = encoded(place, q);
      const double more = certain.moved(now - shown);
      shown = now;
      ASSERT_GE(more, 0.0);
      counted += more;
      ASSERT_LE(counted, path * (1.0 + 1e-12)) << walk << " after " << n;
      if (random.chance(1e-3)) certain.forget();
    }
  }
}

TEST(CertainPath, AlongAnyDirectionIsNearlyTheWholeOfIt) {
  Random random(6);
  for (int n = 0; n < 100; ++n) {
    constexpr double kQuantum = 2e-5, kStride = 3e-5;
    const Vec3 way = random.direction();
    CertainPath certain(kQuantum);
    Vec3 shown = Vec3::Zero();
    double counted = 0.0;
    for (int i = 1; i <= 10000; ++i) {
      const Vec3 now = encoded(i * kStride * way, kQuantum);
      counted += certain.moved(now - shown);
      shown = now;
    }
    EXPECT_GT(counted, 0.96 * 10000 * kStride);
    EXPECT_LE(counted, 10000 * kStride);
  }
}

/// Windows that go round the corner count less. A sum over sqrt(3) would be 0.58 of the way.
TEST(CertainPath, AWayRoundACornerCountsAlongBothSides) {
  CertainPath certain(1e-5);
  double counted = 0.0;
  for (int turn = 0; turn < 20; ++turn)
    for (int i = 0; i < 100; ++i)
      counted += certain.moved(turn % 2 == 0 ? Vec3(1e-5, 0, 0) : Vec3(0, 1e-5, 0));
  EXPECT_GT(counted, 0.75 * 2000 * 1e-5);
  EXPECT_LE(counted, 2000 * 1e-5);
}

}  // namespace
}  // namespace feltwire::certain_path_test
