// Tests the directory of one process.

#include "server/fleet/memory_directory.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/server/fleet/directory_contract.hpp"

namespace feltwire::memory_directory_test {
namespace {

using namespace std::chrono_literals;

TEST(MemoryDirectory, SwapsWhatWasCompared) {
  MemoryDirectory directory;
  test::expect_compare_and_swap(directory);
}

TEST(MemoryDirectory, ShowsWhatThereIsAndEachChange) {
  MemoryDirectory directory;
  test::expect_watch(directory);
}

TEST(MemoryDirectory, AWatchSkipsWhatWasOverwritten) {
  MemoryDirectory directory;
  const auto watch = directory.watch(Bucket::hosts);
  EXPECT_EQ(watch->next(0ns), std::nullopt);
  directory.put(Bucket::hosts, "a", "1");
  directory.put(Bucket::hosts, "b", "1");
  directory.put(Bucket::hosts, "a", "2");
  directory.put(Bucket::scenes, "room", "1");
  EXPECT_EQ(watch->next(0ns), (DirectoryEntry{"b", "1", 2}));
  EXPECT_EQ(watch->next(0ns), (DirectoryEntry{"a", "2", 3}));
  EXPECT_EQ(watch->next(0ns), std::nullopt) << "another bucket";
}

TEST(MemoryDirectory, OneOfManyThreadsWins) {
  MemoryDirectory directory;
  const auto watch = directory.watch(Bucket::scenes);
  constexpr int kThreads = 4, kRounds = 200;
  std::atomic<int> wins{0};
  std::vector<std::jthread> threads;
  for (int thread = 0; thread < kThreads; ++thread) {
    threads.emplace_back([&, thread] {
      std::uint64_t revision = 0;
      for (int round = 0; round < kRounds; ++round) {
        const auto answer =
            directory.compare_and_swap(Bucket::scenes, "room", std::to_string(thread), revision);
        if (answer.result == WriteResult::written) ++wins;
        revision = directory.list(Bucket::scenes)->front().revision;
      }
    });
  }
  threads.clear();
  EXPECT_EQ(directory.list(Bucket::scenes)->front().revision, static_cast<std::uint64_t>(wins))
      << "each win is a revision, and nothing else is";
}

TEST(MemoryDirectory, AWatchWakesForAWriteOfAnotherThread) {
  MemoryDirectory directory;
  const auto watch = directory.watch(Bucket::scenes);
  const std::jthread writer([&] { directory.put(Bucket::scenes, "room", "1"); });
  EXPECT_EQ(watch->next(test::kLongest), (DirectoryEntry{"room", "1", 1}));
}

}  // namespace
}  // namespace feltwire::memory_directory_test
