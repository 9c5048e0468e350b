// A complete tick with its datagrams must not allocate. The test counts calls of operator new, but
// a sanitizer replaces this operator.

#include <gtest/gtest.h>

#include <memory>
#include <sstream>

#include "client/hands/replay_device.hpp"
#include "client/servo/servo.hpp"
#include "client/transport/transport.hpp"
#include "tests/client/peer.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::servo_allocation_test {
namespace {

TEST(Servo, TenThousandTicksOverASocketAllocateNothing) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer brings its own operator new";
#else
  std::istringstream rows(
      "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n3,0.05,0.02,-0.04,0,1,0,0\n20,0,0,0,1,0,0,0\n");
  ReplayDevice device(read_recording(rows, "rows"), builtin_device("touch"));
  SessionParameters parameters;
  parameters.redundancy = kMaxRedundancy - 1;
  parameters.packet_interval = parameters.batch = 2;
  parameters.position_deadband = parameters.force_deadband = 1e-9;
  Servo servo(device.spec(), parameters);
  testing::ScenePeer peer;
  Transport transport(peer.session(), parameters, true);
  test::SealedEncoder encoder(test::Way::down);
  Nanoseconds now{0};
  std::size_t counted = 0;
  std::uint64_t replies = 0;
  for (std::uint64_t i = 1; i <= 10'000; ++i) {
    now += std::chrono::milliseconds(1);
    Reply reply;
    reply.sample_index = i - 1;
    reply.command.elastic = Vec3(0, 0, 1e-4 * static_cast<double>(i));
    reply.predicted = true;
    reply.rates.elastic = Vec3(0, 0, 0.1);
    if (i > 1) peer.send_bytes(encoder.reply(testing::ScenePeer::kSession, i, reply));

    const std::size_t before = test::allocations();
    GoodbyeReason reason;
    while (transport.receive(reply, reason) == Transport::Arrival::reply) {
      servo.take(reply, now);
      ++replies;
    }
    const bool sent = transport.send(*servo.tick(device, now));
    if (sent) servo.sent();
    counted += test::allocations() - before;
    if (sent) peer.receive_bytes();
  }
  EXPECT_EQ(counted, 0u);
  EXPECT_EQ(replies, 9'999u);
  EXPECT_GE(servo.statistics().replies.datagrams, 4'000u);
  EXPECT_LE(servo.statistics().replies.datagrams, 5'000u);
  EXPECT_GT(servo.statistics().max_force, 0.0);

  const std::size_t before = test::allocations();
  const std::unique_ptr<int> proof(new int(1));  // The counter must count this allocation.
  EXPECT_EQ(test::allocations() - before, 1u);
#endif
}

}  // namespace
}  // namespace feltwire::servo_allocation_test
