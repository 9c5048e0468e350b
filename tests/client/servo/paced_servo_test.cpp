// The device's tick paces the servo. Tests stale readings, differing held forces and missing ticks.

#include <gtest/gtest.h>
#include <poll.h>

#include <thread>

#include "client/servo/servo_thread.hpp"
#include "protocol/net/clock.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::paced_servo_test {
namespace {

using testing::ScenePeer;
using testing::servo::at;
using testing::servo::elastic;
using testing::servo::kPeriod;
using testing::servo::parameters;
using testing::servo::reply;

/// Returns the reading that the test sets, and counts the writes.
class ScriptedReadings final : public Device {
 public:
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override { return next; }
  Command write(const Command& on_hand) noexcept override {
    ++writes;
    return last = on_hand;
  }
  void release() noexcept override {}

  DeviceReading next;
  Command last;
  int writes = 0;

 private:
  DeviceSpec spec_ = builtin_device("simulated");
};

DeviceReading stale() {
  DeviceReading reading = at(9, 9, 9);  // The servo must ignore this position.
  reading.fresh = false;
  return reading;
}

struct PacedServo : ::testing::Test {
  ScriptedReadings device;
  Servo servo{device.spec(), parameters("none"), {}};
  Nanoseconds now = testing::servo::seconds(5.0);

  const Sample* tick(const DeviceReading& reading, Nanoseconds after = kPeriod) {
    now += after;
    device.next = reading;
    const Sample* sample = servo.tick(device, now);
    if (sample != nullptr) servo.take(reply(sample->index, force), now);
    return sample;
  }
  Command force = elastic(0, 0, 2);
};

/// A force of 2 N over two periods and 3 mm does 6 mJ of work, as with a reading in time.
TEST_F(PacedServo, AStaleReadingIsNoTick) {
  tick(at(0, 0, 0));
  tick(at(0, 0, 0));
  ASSERT_EQ(servo.held().force(), Vec3(0, 0, 2));
  force = elastic(0, 0, 1);
  const int writes = device.writes;
  EXPECT_EQ(tick(stale()), nullptr);
  EXPECT_EQ(device.writes, writes);
  EXPECT_EQ(servo.held().force(), Vec3(0, 0, 2));
  EXPECT_NE(tick(at(0, 0, 3e-3)), nullptr);
  EXPECT_DOUBLE_EQ(servo.port().delivered().total(), 2.0 * 3e-3);
  EXPECT_EQ(servo.statistics().device.stale_readings, 1u);
  EXPECT_EQ(servo.statistics().device.faults, 0u);
}

TEST_F(PacedServo, ADeviceThatTellsNothingNewForLongHasAFault) {
  tick(at(0, 0, 0));
  tick(at(0, 0, 0));
  const int patient = static_cast<int>(0.25 * servo.parameters().hold_time / 1e-3);
  for (int n = 1; n < patient; ++n) ASSERT_EQ(tick(stale()), nullptr) << n;
  EXPECT_EQ(servo.held().force(), Vec3(0, 0, 2));
  tick(stale());
  tick(stale());
  EXPECT_EQ(device.last.force(), Vec3::Zero());
  EXPECT_GT(servo.statistics().device.faults, 0u);
}

/// The servo multiplies the movement by the force that the device reports as held.
TEST_F(PacedServo, AForceTakenUpLateIsAccountedAsHeldLate) {
  tick(at(0, 0, 0));
  force = elastic(0, 0, 4);
  tick(at(0, 0, 0));
  tick(at(0, 0, 0));
  ASSERT_EQ(servo.held().force(), Vec3(0, 0, 4));
  const double before = servo.port().delivered().total();
  DeviceReading late = at(0, 0, 1e-3);
  // mean of 2 N for three quarters of the tick and 4 N for the rest
  late.held = elastic(0, 0, 2.5);
  tick(late);
  EXPECT_DOUBLE_EQ(servo.port().delivered().total() - before, 2.5e-3);
  EXPECT_EQ(servo.statistics().device.forces_corrected, 1u);
  late = at(0, 0, 2e-3);
  late.held = elastic(0, 0, testing::servo::kNan);
  tick(late);
  EXPECT_EQ(device.last.force(), Vec3::Zero());
  EXPECT_EQ(servo.statistics().device.faults, 1u);
}

/// The device holds a force longer than the servo assumed. The account must subtract the energy of
/// this time from the balance.
TEST_F(PacedServo, TheAccountPaysForWhatWasReallyHeld) {
  SessionParameters shaped = parameters("shaped");
  Servo counted(device.spec(), shaped, {}), corrected(device.spec(), shaped, {});
  ASSERT_TRUE(counted.account());
  for (Servo* one : {&counted, &corrected}) {
    now = testing::servo::seconds(5.0);
    for (int n = 0; n < 20; ++n) {  // Free movement dissipates energy and fills the account.
      device.next = at(0, 0, 1e-4 * n);
      one->tick(device, now += kPeriod);
    }
    device.next = at(0, 0, 2e-3);
    if (one == &corrected) device.next.held = elastic(0, 0, 1);
    one->tick(device, now += kPeriod);
  }
  EXPECT_NEAR(counted.account()->balance() - corrected.account()->balance(), 1e-4, 1e-9);
}

/// Ticks a given number of times, or every millisecond until it has a force.
class Paced final : public Device {
 public:
  explicit Paced(int ticks) : left_(ticks) {}
  const DeviceSpec& spec() const override { return spec_; }
  Nanoseconds longest_tick() const override { return std::chrono::milliseconds(2); }
  bool await_tick(Nanoseconds) noexcept override {
    if (left_ == kUntilItPulls) return ::poll(nullptr, 0, 1) == 0 && !pulled_once;
    if (left_ == 0) return false;
    --left_;
    return true;
  }
  DeviceReading read(Nanoseconds) noexcept override {
    ++reads;
    return {.pose = {}, .ended = left_ == 0 && ends};
  }
  Command write(const Command& on_hand) noexcept override {
    pulled.store(!on_hand.force().isZero(0.0));
    if (pulled) pulled_once.store(true);
    return on_hand;
  }
  void release() noexcept override { pulled.store(false); }

  static constexpr int kUntilItPulls = -1;
  bool ends = false;
  std::atomic<int> reads{0};
  std::atomic<bool> pulled{false}, pulled_once{false};

 private:
  DeviceSpec spec_ = builtin_device("simulated");
  std::atomic<int> left_;
};

TEST(PacedLoop, TicksWhenTheDeviceDoes) {
  ScenePeer peer;
  Transport transport(peer.session(), {}, false);
  Paced device(500);
  device.ends = true;
  Servo servo(device.spec(), parameters("none"), {});
  Event stop;
  auto result = std::make_unique<LoopResult>();
  run_servo_loop(device, servo, transport, {}, stop, {}, *result);
  EXPECT_EQ(result->end, EndReason::device_ended);
  EXPECT_GE(device.reads, 500);
  EXPECT_EQ(servo.statistics().samples, static_cast<std::uint64_t>(device.reads.load()));
}

struct WithoutTicks {
  bool ended_well = false, stood_still = false;
  EndReason end{};
  std::uint64_t device_faults = 0;
};
WithoutTicks run_without_ticks() {
  ScenePeer peer;
  SessionParameters p = parameters("none");
  p.hold_time = 1.0;
  auto owned = std::make_unique<Paced>(Paced::kUntilItPulls);
  Paced& device = *owned;
  const auto task = std::make_shared<ServoTask>(
      std::move(owned), std::make_shared<Transport>(peer.session(), p, false), p, ServoOptions{});
  task->let_go_after = 0.15;
  ServoThread thread(task);
  while (!device.pulled_once) {
    const auto received = peer.receive();
    if (received.kind == DatagramKind::samples)
      peer.send(ScenePeer::reply_to(received.batch.samples[0], {.elastic = Vec3(0, 0, 3)}));
  }
  test::eventually("the force is off", [&] { return !device.pulled; });
  return {.ended_well = thread.end(),
          .stood_still = task->result.stood_still,
          .end = task->result.end,
          .device_faults = task->servo.statistics().device.faults};
}

/// A device that returns without a tick is late, but its servo thread runs. The servo removes the
/// force at a quarter of the hold time, and the stall detector removes it later. A busy machine may
/// delay the thread longer. The test therefore has several attempts.
TEST(PacedLoop, ADeviceWithoutTicksIsNoStandstill) {
  WithoutTicks run = run_without_ticks();
  for (int again = 0; again < 5 && run.stood_still; ++again) run = run_without_ticks();
  EXPECT_TRUE(run.ended_well);
  EXPECT_EQ(run.end, EndReason::requested);
  EXPECT_FALSE(run.stood_still);
  EXPECT_GT(run.device_faults, 0u);
}

/// The device is unplugged. The force ends long before the hold time, and the loop continues.
TEST(PacedLoop, ADeviceWithoutTicksHasAFaultAndHoldsNothing) {
  ScenePeer peer;
  Transport transport(peer.session(), {}, false);
  Paced device(Paced::kUntilItPulls);
  Servo servo(device.spec(), parameters("none"), {});
  Event stop;
  auto result = std::make_unique<LoopResult>();
  Ring<LiveStatus> statuses(1 << 8);
  std::thread loop(
      [&] { run_servo_loop(device, servo, transport, {}, stop, {.status = &statuses}, *result); });
  while (!device.pulled_once) {
    const auto received = peer.receive();
    if (received.kind == DatagramKind::samples)
      peer.send(ScenePeer::reply_to(received.batch.samples[0], {.elastic = Vec3(0, 0, 3)}));
  }
  LiveStatus status;
  test::eventually("two status lines after the last tick", [&] {
    while (statuses.pop(status))
      if (status.time > 0.4) return true;
    return false;
  });
  EXPECT_FALSE(device.pulled);
  stop.set();
  loop.join();
  EXPECT_EQ(result->end, EndReason::requested);
  EXPECT_GT(servo.statistics().device.faults, 1u);
  EXPECT_LT(servo.statistics().device.faults, 1000u);  // The servo sleeps between its reads.
}

}  // namespace
}  // namespace feltwire::paced_servo_test
