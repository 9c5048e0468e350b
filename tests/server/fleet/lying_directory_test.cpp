// Tests each lie of the lying directory, and a host that lives with them.

#include "tests/server/fleet/lying_directory.hpp"

#include <gtest/gtest.h>

#include "server/fleet/memory_directory.hpp"
#include "server/fleet/ownership.hpp"
#include "server/fleet/record_codec.hpp"
#include "tests/server/fleet/directory_contract.hpp"

namespace feltwire::lying_directory_test {
namespace {

using namespace std::chrono_literals;
using test::LyingDirectory;

class Lies : public ::testing::Test {
 protected:
  std::vector<std::string> shown(DirectoryWatch& watch) {
    std::vector<std::string> values;
    while (const auto entry = watch.next(0ns)) values.push_back(entry->value);
    return values;
  }
  WriteAnswer swap(const std::string& value, std::uint64_t expected) {
    return directory_.compare_and_swap(Bucket::scenes, "room", value, expected);
  }

  MemoryDirectory truth_;
  LyingDirectory directory_{truth_};
};
using Values = std::vector<std::string>;

TEST_F(Lies, WithoutALieItIsADirectory) {
  test::expect_compare_and_swap(directory_);
  test::expect_watch(directory_);
}

TEST_F(Lies, LosesItsLastWritesAndGivesTheirRevisionsAgain) {
  ASSERT_EQ(swap("1", 0).revision, 1u);
  ASSERT_EQ(swap("2", 1).revision, 2u);
  ASSERT_EQ(swap("3", 2).revision, 3u);
  directory_.lose(Bucket::scenes, 2);
  EXPECT_EQ(directory_.list(Bucket::scenes)->front().value, "1");
  EXPECT_EQ(shown(*directory_.watch(Bucket::scenes)), Values{"1"});
  EXPECT_EQ(swap("x", 3).result, WriteResult::conflict);
  EXPECT_EQ(swap("x", 1), (WriteAnswer{WriteResult::written, 2}));
  EXPECT_EQ(truth_.list(Bucket::scenes)->front().value, "x") << "the truth was written too";
  directory_.lose(Bucket::scenes, 9);
  EXPECT_TRUE(directory_.list(Bucket::scenes)->empty());
  EXPECT_EQ(swap("y", 0).result, WriteResult::written);
}

TEST_F(Lies, AnswersStale) {
  swap("1", 0);
  swap("2", 1);
  directory_.be_stale(1);
  EXPECT_EQ(directory_.list(Bucket::scenes)->front().value, "1");
  directory_.be_stale(0);
  EXPECT_EQ(directory_.list(Bucket::scenes)->front().value, "2");
}

TEST_F(Lies, AnswersLate) {
  const auto watch = directory_.watch(Bucket::scenes);
  directory_.hold_back(true);
  swap("1", 0);
  EXPECT_EQ(shown(*watch), Values{});
  directory_.hold_back(false);
  EXPECT_EQ(shown(*watch), Values{"1"});
}

TEST_F(Lies, AnswersTwiceAlsoWhatItHasLost) {
  const auto watch = directory_.watch(Bucket::scenes);
  swap("1", 0);
  swap("2", 1);
  EXPECT_EQ(shown(*watch), Values{"2"});
  directory_.lose(Bucket::scenes, 1);
  directory_.repeat(Bucket::scenes);
  EXPECT_EQ(shown(*watch), (Values{"1", "2"}));
}

TEST_F(Lies, WritesWithoutAnAnswer) {
  directory_.answer_no_writes(true);
  EXPECT_EQ(swap("1", 0).result, WriteResult::unknown);
  directory_.answer_no_writes(false);
  EXPECT_EQ(directory_.list(Bucket::scenes)->front().value, "1");
}

/// The directory forgets a takeover. The owner writes it again, and the former owner lets go.
TEST_F(Lies, AHostBringsBackWhatWasLost) {
  const HostName a{"a", 11}, b{"b", 22};
  const auto write = [&](SceneOwnership& scene) {
    const auto record = record_to_write(scene);
    if (!record) return false;
    const auto answer = swap(encode(*record), scene.revision);
    if (answer.result == WriteResult::written) finish_write(scene, *record, answer.revision);
    return answer.result == WriteResult::written;
  };
  const auto read = [&](SceneOwnership& scene) {
    bool lost = false;
    const auto entries = directory_.list(Bucket::scenes);
    for (const auto& entry : *entries)
      lost = see_record(scene, *decode_scene_record(entry.value), entry.revision) || lost;
    return lost;
  };
  SceneOwnership first, second;
  const SceneRecord claimed = claim(first, a, {});
  ASSERT_TRUE(finish_claim(first, claimed, swap(encode(claimed), 0).revision));
  reserve_standby(first, b);
  ASSERT_TRUE(write(first));
  read(second);
  ASSERT_TRUE(take_over(second, b));
  ASSERT_TRUE(write(second));
  directory_.lose(Bucket::scenes, 1);
  EXPECT_FALSE(read(first)) << "the first owner does not know of the second";
  EXPECT_FALSE(write(second)) << "it writes over a revision that is gone";
  EXPECT_FALSE(read(second)) << "an old record takes nothing from the later owner";
  EXPECT_TRUE(write(second));
  EXPECT_TRUE(read(first));
  EXPECT_EQ(answer_join(first, {}), JoinAnswer::redirected);
  EXPECT_EQ(answer_join(second, {}), JoinAnswer::accepted);
}

}  // namespace
}  // namespace feltwire::lying_directory_test
