#include "core/base/parallel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <future>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

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

/// The step and the share of a text like "mesh, step 2, 40 %".
std::pair<int, int> step_and_share(const std::string& text) {
  int step = 1, share = 0;
  if (std::sscanf(text.c_str(), "mesh, step %d, %d %%", &step, &share) < 2) {
    step = 1;
    std::sscanf(text.c_str(), "mesh, %d %%", &share);
  }
  return {step, share};
}

TEST(Parallel, ProgressNeverGoesBack) {
  CancellableWork work;
  work.begin("mesh");
  EXPECT_EQ(work.progress(), "mesh");
  std::vector<std::string> told;
  std::mutex telling;
  const auto tell = [&](std::size_t) {
    const std::lock_guard lock(telling);
    told.push_back(work.progress());
  };
  {
    const WorkScope scope(&work);
    parallel_for(4, tell);
    parallel_for(100, tell);
    // A call inside of another one is no step of its own.
    parallel_for(10, [&](std::size_t) { parallel_for(10, tell); });
  }
  EXPECT_TRUE(std::ranges::is_sorted(told, {}, step_and_share)) << ::testing::PrintToString(told);
  EXPECT_THAT(told, ::testing::Contains("mesh, step 2, 99 %"));
  EXPECT_EQ(work.progress(), "mesh, step 3, 90 %");
}

}  // namespace
}  // namespace feltwire::parallel_test
