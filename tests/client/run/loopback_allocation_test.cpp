// Running servers and servo loops must not allocate for any datagram or tick. The test uses real
// sockets.

#include "tests/client/loopback.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::loopback_allocation_test {
namespace {

using LoopbackAllocation = testing::Loopback;

TEST_F(LoopbackAllocation, AServedTickAllocatesNothingInAnyThread) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer brings its own malloc";
#endif
  constexpr std::size_t kTicks = 1000;
  testing::Client bounded(endpoint, "t,x,y,z\n0,0,0,-0.001\n100,0.2,0,-0.001\n", {}, "floor");
  SessionParameters with_model;
  with_model.local_model = true;
  with_model.side = BoundingSide::both;
  testing::Client modelled(endpoint, "t,x,y,z\n0,0.1,0,-0.001\n100,0,0.2,-0.001\n", with_model,
                           "floor");
  bounded.start();
  modelled.start();
  const auto answered = [](const TickRecord& row) { return row.age >= 0.0; };
  bounded.next_tick("an answer", answered);
  modelled.next_tick("an answer", answered);
  // The first ticks may allocate.
  for (int n = 0; n < 200; ++n) bounded.next_tick("a tick", answered);

  const std::size_t before = test::allocations_of_others();
  for (std::size_t n = 0; n < kTicks; ++n) bounded.next_tick("a tick", answered);
  // The control thread may read its files sometimes.
  EXPECT_LT(test::allocations_of_others() - before, kTicks / 10);
  bounded.stop.set();
  modelled.stop.set();
  bounded.finish();
  modelled.finish();
  EXPECT_GT(bounded.servo.statistics().replies.answered, kTicks / 2);
  EXPECT_GT(modelled.servo.statistics().replies.answered, kTicks / 2);
}

}  // namespace
}  // namespace feltwire::loopback_allocation_test
