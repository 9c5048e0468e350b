// The whole tick with its datagrams takes no memory. Counts what operator new gives; a sanitizer
// has its own.

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <sstream>

#include "client/devices/replay.hpp"
#include "client/servo.hpp"
#include "client/transport.hpp"
#include "tests/client/peer.hpp"

#ifndef FELTWIRE_SANITIZED
namespace {
thread_local bool counting = false;
thread_local std::size_t allocations = 0;
}  // namespace

void* operator new(std::size_t size) {
  if (counting) ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  if (counting) ++allocations;
  const auto step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
#endif

namespace feltwire {
namespace {

TEST(Servo, TenThousandTicksOverASocketAllocateNothing) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a sanitizer brings its own operator new";
#else
  std::istringstream rows(
      "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n3,0.05,0.02,-0.04,0,1,0,0\n20,0,0,0,1,0,0,0\n");
  ReplayDevice device(read_recording(rows, "rows"), builtin_device("touch"));
  Servo servo(device.spec(), {});
  testing::ScenePeer peer;
  Transport transport(peer.address(), testing::ScenePeer::kSession, kMaxRedundancy, true);
  Encoder encoder;
  Nanoseconds now{0};
  std::size_t counted = 0;
  std::uint64_t replies = 0;
  for (std::uint64_t i = 1; i <= 10'000; ++i) {
    now += std::chrono::milliseconds(1);
    Reply reply;
    reply.sample_index = i - 1;
    reply.command.elastic = Vec3(0, 0, 1e-4 * static_cast<double>(i));
    if (i > 1) peer.send_bytes(encoder.reply(testing::ScenePeer::kSession, i, reply));

    counting = true;
    GoodbyeReason reason;
    while (transport.receive(reply, reason) == Transport::Arrival::reply) {
      servo.take(reply, now);
      ++replies;
    }
    transport.send(*servo.tick(device, now));
    counting = false;
    counted += std::exchange(allocations, 0);
    peer.receive_bytes();
  }
  EXPECT_EQ(counted, 0u);
  EXPECT_EQ(replies, 9'999u);
  EXPECT_GT(servo.statistics().max_force, 0.0);

  counting = true;
  const std::unique_ptr<int> proof(new int(1));  // the counter counts
  counting = false;
  EXPECT_EQ(std::exchange(allocations, 0), 1u);
#endif
}

}  // namespace
}  // namespace feltwire
