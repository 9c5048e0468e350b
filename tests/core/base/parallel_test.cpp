#include "core/base/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <numeric>
#include <stdexcept>
#include <thread>

namespace feltwire::parallel_test {
namespace {

TEST(Parallel, EveryIndexOnce) {
  std::vector<int> calls(1000, 0);
  parallel_for(calls.size(), [&](std::size_t i) { ++calls[i]; });
  EXPECT_EQ(std::accumulate(calls.begin(), calls.end(), 0), 1000);
  EXPECT_EQ(*std::max_element(calls.begin(), calls.end()), 1);
  parallel_for(0, [](std::size_t) { FAIL(); });
}

TEST(Parallel, TwoCallsRunAtTheSameTime) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "this machine has one core";
  // Each call waits for the other. On one thread the first call stops after a timeout.
  std::promise<void> arrived[2];
  std::atomic<int> met{0};
  parallel_for(2, [&](std::size_t i) {
    arrived[i].set_value();
    if (arrived[1 - i].get_future().wait_for(std::chrono::minutes(1)) == std::future_status::ready)
      ++met;
  });
  EXPECT_EQ(met, 2);
}

TEST(Parallel, AFailureIsRethrownAndEndsTheRest) {
  std::atomic<int> calls{0};
  const auto work = [&](std::size_t i) {
    ++calls;
    if (i == 3) throw std::runtime_error("three");
  };
  EXPECT_THROW(parallel_for(1'000'000, work), std::runtime_error);
  EXPECT_LT(calls, 1'000'000);
}

}  // namespace
}  // namespace feltwire::parallel_test
