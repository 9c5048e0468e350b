// examples/my_bound.cpp: the laboratory must test a method that is not part of feltwire.

#include <gmock/gmock.h>

#include "tests/support/program.hpp"

namespace feltwire::my_bound_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(MyBound, KeepsItsPromiseAndIsCompared) {
  const test::Outcome judged = test::Program(FELTWIRE_MY_BOUND, {}).finish();
  EXPECT_EQ(judged.status, 0) << judged.out << judged.error;
  EXPECT_THAT(judged.out, Not(HasSubstr("FAILED")));
  // Every task's table must include the method.
  for (const char* task : {"wall", "sphere", "corner", "edge", "torus", "stick_slip", "tap"})
    EXPECT_THAT(judged.out, HasSubstr(task));
  EXPECT_THAT(judged.out, HasSubstr("my_bound "));
}

TEST(MyBound, AWrongSignIsFound) {
  const test::Outcome judged = test::Program(FELTWIRE_MY_BOUND, {"--wrong-sign"}).finish();
  EXPECT_EQ(judged.status, 1) << judged.out << judged.error;
  EXPECT_THAT(judged.out, HasSubstr("FAILED  an ordinary hand, my_bound, double"));
  EXPECT_THAT(judged.out, Not(HasSubstr("contact_frame, double: ")));
}

TEST(MyBound, AnUnknownOptionIsRefused) {
  EXPECT_EQ(test::Program(FELTWIRE_MY_BOUND, {"--sign"}).finish().status, 2);
}

}  // namespace
}  // namespace feltwire::my_bound_test
