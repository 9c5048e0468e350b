#include "sim/measure/cost.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace feltwire::cost_test {
namespace {

TEST(Cost, IsTheMedianOverLapsOfTheTimeOfACall) {
  constexpr std::size_t kCount = 10, kLaps = 5;
  double now = 0.0;  // [s]
  std::vector<int> calls(kCount, 0);
  std::size_t lap = 0;
  // A call takes 100 ns in the first lap and 200 ns in the second. A disturbance adds 1 s to one
  // lap.
  const auto work = [&](std::size_t i) {
    if (i == 0) ++lap;
    ++calls[i];
    now += 100e-9 * static_cast<double>(lap);
    if (lap == 2 && i == 7) now += 1.0;
  };
  EXPECT_NEAR(cost_ns(kCount, work, kLaps, [&] { return now; }), 400.0, 1e-6);
  EXPECT_EQ(calls, std::vector<int>(kCount, static_cast<int>(kLaps)));
}

TEST(Cost, IsOfTheCallingThreadsCpu) {
  constexpr double kMuch = 50e-3;  // [s]
  const double before = cpu_seconds();
  double others = 0.0;
  std::thread other([&] {
    while (cpu_seconds() < kMuch) {
    }
    others = cpu_seconds();
  });
  other.join();
  EXPECT_GE(others, kMuch);
  EXPECT_LT(cpu_seconds() - before, kMuch);
}

}  // namespace
}  // namespace feltwire::cost_test
