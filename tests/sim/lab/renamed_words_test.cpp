// feltwire-lab must refuse a former name of a command or option, and name the present one.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/support/program.hpp"

namespace feltwire::renamed_words_test {
namespace {

using ::testing::HasSubstr;

struct Renamed {
  std::vector<std::string> words;
  std::string advice;
};

TEST(RenamedWords, AFormerNameIsRefusedWithThePresentOne) {
  const std::vector<Renamed> all = {
      {{"sides", "--out", "x"}, "; sides is now where-to-bound; see --help"},
      {{"parts", "x.obj"}, "; parts is now convex-parts; see --help"},
      {{"extremes", "--told-damping", "1.05"},
       "; --told-damping is now --assumed-damping; see --help"},
      {{"where-to-bound", "--told-damping=1.05"},
       "; --told-damping is now --assumed-damping; see --help"}};
  for (const Renamed& one : all) {
    const test::Outcome outcome = test::Program(FELTWIRE_LAB_PROGRAM, one.words).finish();
    EXPECT_EQ(outcome.status, 2) << one.advice;
    EXPECT_THAT(outcome.error, HasSubstr(one.advice));
  }
}

}  // namespace
}  // namespace feltwire::renamed_words_test
