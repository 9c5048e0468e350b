#include "protocol/net/real_time.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace feltwire::real_time_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(RealTime, WhatIsNotPermittedIsNamedWithTheRemedy) {
  EXPECT_EQ(missing({true, true}, kServoPriority), "");
  EXPECT_THAT(missing({false, true}, kServoPriority), StartsWith("real-time scheduling is not"));
  EXPECT_THAT(missing({true, false}, kServoPriority), StartsWith("locking memory is not"));
  EXPECT_THAT(missing({false, false}, kServoPriority),
              ::testing::AllOf(StartsWith("real-time scheduling and locking memory are not"),
                               HasSubstr("CAP_SYS_NICE"), HasSubstr("memlock")));
}

TEST(RealTime, WhatWasNotAskedForIsNotMissing) {
  EXPECT_EQ(missing({false, true}, 0), "");
  EXPECT_THAT(missing({false, false}, 0), StartsWith("locking memory is not"));
}

}  // namespace
}  // namespace feltwire::real_time_test
