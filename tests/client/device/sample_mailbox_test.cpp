// Tests the mailbox between a device callback and the servo thread. The mailbox must report exactly
// the held force.

#include "client/device/sample_mailbox.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "protocol/net/clock.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::sample_mailbox_test {
namespace {

constexpr Nanoseconds kLong = std::chrono::seconds(10);  // longer than any thread needs
constexpr Nanoseconds kNone{0};

DeviceReading at(double x) { return {.pose = {.position = Vec3(x, 0, 0)}}; }
Command pull(double force) { return {.elastic = Vec3(0, 0, force)}; }

/// Runs the servo's half of a tick in another thread, and the device's half in this thread.
template <class Servo>
Command exchanged(SampleMailbox& mailbox, double x, Servo servo) {
  std::thread other([&] {
    EXPECT_TRUE(mailbox.await(monotonic_now() + kLong));
    servo(mailbox.newest());
  });
  const Command applied = mailbox.exchange(at(x), kLong);
  other.join();
  return applied;
}

TEST(SampleMailbox, AForceIsUsedInTheTickOfItsReading) {
  SampleMailbox mailbox(5);
  const Command applied = exchanged(mailbox, 0.25, [&](const DeviceReading& reading) {
    EXPECT_TRUE(reading.fresh);
    EXPECT_EQ(reading.pose.position.x(), 0.25);
    EXPECT_EQ(mailbox.write(pull(2)), pull(2));
  });
  EXPECT_EQ(applied, pull(2));
  EXPECT_FALSE(mailbox.newest().fresh);  // A reading is fresh only once.
}

/// The mailbox must drop a late force, because the servo already got the report that this force is
/// not held.
TEST(SampleMailbox, AForceThatComesTooLateIsDropped) {
  SampleMailbox mailbox(5);
  exchanged(mailbox, 0, [&](const DeviceReading&) { mailbox.write(pull(2)); });
  // Without an answer the mailbox repeats the last force.
  EXPECT_EQ(mailbox.exchange(at(1), kNone), pull(2));
  EXPECT_EQ(mailbox.newest().pose.position.x(), 1.0);
  EXPECT_EQ(mailbox.write(pull(5)).force().z(), mailbox.write(pull(7)).force().z());
  EXPECT_EQ(mailbox.exchange(at(2), kNone), pull(2));
  const DeviceReading told = mailbox.newest();
  ASSERT_TRUE(told.held.has_value());
  EXPECT_DOUBLE_EQ(told.held->force().z(), 2.0);
}

TEST(SampleMailbox, AServoThatFallsSilentHoldsNothing) {
  SampleMailbox mailbox(3);
  exchanged(mailbox, 0, [&](const DeviceReading&) { mailbox.write(pull(2)); });
  for (int n = 0; n < 3; ++n) EXPECT_EQ(mailbox.exchange(at(n), kNone), pull(2)) << n;
  EXPECT_EQ(mailbox.exchange(at(4), kNone), Command{});
  // Ticks beyond the capacity of the mailbox must change nothing.
  for (int n = 0; n < 200; ++n) EXPECT_EQ(mailbox.exchange(at(n), kNone), Command{}) << n;
}

TEST(SampleMailbox, ReleaseIsForGood) {
  SampleMailbox mailbox(5);
  exchanged(mailbox, 0, [&](const DeviceReading&) { mailbox.write(pull(2)); });
  mailbox.release();
  EXPECT_EQ(mailbox.exchange(at(1), kLong), Command{});  // exchange() must not wait.
  EXPECT_EQ(mailbox.write(pull(3)), Command{});
}

/// The device holds the old force until the new force arrives. The reported mean has the energy of
/// both. If the force did not change in a tick, the mean is that force.
TEST(SampleMailbox, AReadingTellsWhatWasHeldSinceTheOneBefore) {
  SampleMailbox mailbox(5);
  exchanged(mailbox, 0, [&](const DeviceReading& first) {
    EXPECT_FALSE(first.held.has_value());
    mailbox.write(pull(4));
  });
  double told = -1.0;
  exchanged(mailbox, 1, [&](const DeviceReading& second) {
    told = second.held.value_or(Command{}).force().z();
    mailbox.write(pull(4));
  });
  EXPECT_GT(told, 0.0);
  EXPECT_LT(told, 4.0);  // [N] mean of 0 N before the answer and 4 N after it
  exchanged(mailbox, 2, [&](const DeviceReading& third) {
    EXPECT_DOUBLE_EQ(third.held.value_or(Command{}).force().z(), 4.0);
    mailbox.write(pull(4));
  });
  mailbox.cut_to(pull(1));  // A device with a hot amplifier reduces its force.
  mailbox.exchange(at(3), kNone);
  EXPECT_LT(mailbox.newest().held.value_or(pull(9)).force().z(), 4.0);
}

/// The mailbox reports a fault once, even if the servo thread sleeps during the tick of the fault.
TEST(SampleMailbox, AFaultThatWasSleptThroughIsTold) {
  SampleMailbox mailbox(5);
  DeviceReading faulty = at(1);
  faulty.ok = false;
  mailbox.exchange(at(0), kNone);
  mailbox.exchange(faulty, kNone);
  mailbox.exchange(at(2), kNone);
  const DeviceReading told = mailbox.newest();
  EXPECT_FALSE(told.ok);
  EXPECT_EQ(told.pose.position.x(), 2.0);
  mailbox.exchange(at(3), kNone);
  EXPECT_TRUE(mailbox.newest().ok);
}

/// Both threads run at full speed, and some answers are late. The device must apply the answer to
/// the current reading or keep the last force. No thread may allocate.
TEST(SampleMailbox, NoAnswerIsTakenForThatOfAnotherReading) {
  constexpr int kTicks = 20'000;
  SampleMailbox mailbox(kTicks);
  std::atomic<bool> over{false};
  std::size_t used = 1;
  int in_time = 0, claimed = 0;
  std::thread servo([&] {
    const std::size_t before = test::allocations();
    while (!over.load()) {
      if (!mailbox.await(monotonic_now() + std::chrono::milliseconds(1))) continue;
      const double asked = mailbox.newest().pose.position.x();
      if (mailbox.write(pull(asked)).force().z() == asked) ++claimed;
    }
    used = test::allocations() - before;
  });
  const std::size_t before = test::allocations();
  Command last;
  for (int n = 1; n <= kTicks; ++n) {
    const Nanoseconds patience = n % 3 == 0 ? kNone : std::chrono::microseconds(n % 100);
    const Command applied = mailbox.exchange(at(n), patience);
    if (applied.force().z() == n)
      ++in_time;
    else
      ASSERT_EQ(applied, last) << n;
    last = applied;
  }
  EXPECT_EQ(test::allocations() - before, 0u);
  over.store(true);
  servo.join();
  EXPECT_EQ(used, 0u);
  EXPECT_EQ(claimed, in_time);  // write() must report the held force.
  EXPECT_GT(in_time, 0);
}

}  // namespace
}  // namespace feltwire::sample_mailbox_test
