// Tests the measures of a lost contact on manual samples.

#include "sim/studies/teleop/lost_contact.hpp"

#include <gtest/gtest.h>

namespace feltwire::teleop {
namespace {

constexpr double kPeriod = 1e-3;  // [s]
constexpr std::size_t kEnd = 1000, kLost = 200, kAgain = 700;

/// Returns samples in which the robot has no contact from kLost to kAgain. During this time its
/// tool is 1 mm below the surface. The hand gets `force` [N] until sample `free`.
std::vector<BenchSample> run(std::size_t free, double force = 1.0) {
  std::vector<BenchSample> samples(kEnd + 1);
  for (std::size_t n = 0; n <= kEnd; ++n) {
    samples[n].contact = n < kLost || n >= kAgain ? 2.0 : 0.0;
    samples[n].robot = 1e-3;
    samples[n].held = n <= free || n > kAgain ? force : 0.0;
  }
  return samples;
}

TEST(LostContact, CountsShareAndTimeFromTheLoss) {
  const auto lost = lost_contact(run(300), 0, kEnd, 40, kPeriod);
  ASSERT_TRUE(lost);
  EXPECT_DOUBLE_EQ(lost->felt, 100.0 / (kAgain - kLost));
  EXPECT_NEAR(lost->release, (300 - kLost - 40) * kPeriod, 1e-12);
  const auto weak = lost_contact(run(300, 0.2), 0, kEnd, 40, kPeriod);
  EXPECT_EQ(weak->felt, 0.0) << "less than is counted as felt";
  EXPECT_NEAR(weak->release, (300 - kLost - 40) * kPeriod, 1e-12) << "more than free";
}

TEST(LostContact, AToolThatHasComeOutIsNoEvidence) {
  auto samples = run(300);
  for (std::size_t n = kLost; n < 250; ++n) samples[n].robot = -1e-3;
  EXPECT_NEAR(lost_contact(samples, 0, kEnd, 0, kPeriod)->release, 50 * kPeriod, 1e-12);
  for (std::size_t n = kLost; n < kAgain; ++n) samples[n].robot = -1e-3;
  EXPECT_EQ(lost_contact(samples, 0, kEnd, 0, kPeriod)->release, 0.0);
}

TEST(LostContact, AHandThatIsNeverFreeCountsAsLongAsItCanBeSeen) {
  EXPECT_NEAR(lost_contact(run(kEnd), 0, kEnd, 40, kPeriod)->release, (kAgain - kLost) * kPeriod,
              1e-12);
}

TEST(LostContact, NoneWithoutALoss) {
  auto samples = run(kEnd);
  for (BenchSample& s : samples) s.contact = 1.0;
  EXPECT_FALSE(lost_contact(samples, 0, kEnd, 0, kPeriod));
}

}  // namespace
}  // namespace feltwire::teleop
