// At loading, a scene with slow answers must be reported. The clock is simulated.

#include "server/scene/answer_time.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/moving.hpp"
#include "tests/server/make.hpp"

namespace feltwire::answer_time_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// Returns a clock that advances by `by` at each reading.
std::function<Nanoseconds()> stepping(Nanoseconds by) {
  return [by, now = Nanoseconds(0)]() mutable { return now += by; };
}

TEST(AnswerTime, ASceneThatIsQuickIsNotWarnedOf) {
  EXPECT_EQ(warning_of_slow_answers(test::room(), stepping(900us)), std::nullopt);
  const AnswerTime time = measure_answers(test::room(), stepping(100us));
  EXPECT_NEAR(time.usual, 1e-4, 1e-12);
  EXPECT_NEAR(time.slow, 1e-4, 1e-12);
  EXPECT_EQ(time.answers, 128u);  // 64 hands with two samples each
}

TEST(AnswerTime, ASceneThatTakesLongerThanAPeriodIs) {
  const auto warning = warning_of_slow_answers(test::room(), stepping(5ms));
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning, HasSubstr("takes 5 ms"));
  EXPECT_THAT(*warning, HasSubstr("longer than the usual servo period of 1 ms"));
}

/// A tenth of slow answers must suffice, because a hand may stay at a slow position.
TEST(AnswerTime, OneInTenIsEnough) {
  int looks = 0;
  Nanoseconds now{0};
  const auto clock = [&]() { return now += ++looks % 5 == 0 ? 2ms : Nanoseconds(10us); };
  EXPECT_TRUE(warning_of_slow_answers(test::room(), clock));
}

/// A few answers of half a minute must suffice, so the measurement ends soon.
TEST(AnswerTime, AFewVerySlowAnswersAreEnough) {
  EXPECT_EQ(measure_answers(test::room(), stepping(30s)).answers, 6u);
}

TEST(AnswerTime, AsksWhatMoves) {
  EXPECT_EQ(measure_answers(test::explosive(), stepping(10us)).answers, 128u);
}

TEST(AnswerTime, ByTheRealClockIsAboveZero) {
  const AnswerTime time = measure_answers(test::room());
  EXPECT_GT(time.usual, 0.0);
  EXPECT_GE(time.slow, time.usual);
}

}  // namespace
}  // namespace feltwire::answer_time_test
