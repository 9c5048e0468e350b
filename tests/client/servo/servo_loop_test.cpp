#include "client/servo/servo_loop.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <numeric>
#include <thread>

#include "tests/client/peer.hpp"

namespace feltwire::servo_loop_test {
namespace {

using testing::ScenePeer;

/// A device that does not move and keeps the last command. It ends the run after some readings.
class StillDevice final : public Device {
 public:
  explicit StillDevice(std::uint64_t readings) : readings_left_(readings) {}
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override {
    if (readings_left_ > 0) --readings_left_;
    return {.pose = {}, .ended = readings_left_ == 0};
  }
  Command write(const Command& on_hand) noexcept override {
    largest = std::max(largest, on_hand.force().norm());
    ++writes;
    if (on_hand.force() != Vec3::Zero()) pulled_at = writes;
    return last = on_hand;
  }
  bool lower_tool(Nanoseconds) noexcept override {
    pulled_when_asked |= last.force() != Vec3::Zero();
    return ++asked_to_lower > steps_to_lower;
  }
  void release() noexcept override {
    last = {};
    writes_at_release = writes;
    ++released;
  }
  int steps_to_lower = 0, asked_to_lower = 0, writes = 0, writes_at_release = 0;
  int pulled_at = 0;  // number of the newest write with a force
  bool pulled_when_asked = false;
  int released = 0;
  double largest = 0.0;
  Command last;

 private:
  DeviceSpec spec_ = builtin_device("simulated");
  std::uint64_t readings_left_;
};

/// Runs a servo loop in its own thread. The test answers as the server.
struct LoopRun {
  ScenePeer peer;
  Transport transport{peer.session(), {}, false};
  StillDevice device;
  Servo servo;
  Ring<TickRecord> records{1 << 16};
  Ring<LiveStatus> statuses{1 << 10};
  std::unique_ptr<LoopResult> result = std::make_unique<LoopResult>();
  Event stop;
  LoopOptions options;
  LoopOutputs outputs{.status = &statuses, .record = &records};
  std::thread thread;

  explicit LoopRun(const LoopOptions& limits,
                   std::uint64_t readings = std::numeric_limits<std::uint64_t>::max(),
                   int steps_to_lower = 0)
      : device(readings), servo(device.spec(), unbounded()), options(limits) {
    device.steps_to_lower = steps_to_lower;
    thread = std::thread(
        [this] { run_servo_loop(device, servo, transport, options, stop, outputs, *result); });
  }
  ~LoopRun() {
    stop.set();
    if (thread.joinable()) thread.join();
  }
  static SessionParameters unbounded() {
    SessionParameters p;
    p.mode = "none";
    p.servo_period = 2e-3;
    return p;
  }
  /// Answers every sample until the client sends a goodbye. Returns the last sample.
  Sample answer_until_goodbye(const std::function<void(const Sample&)>& answer) {
    Sample last;
    while (true) {
      const auto received = peer.receive();
      if (received.kind != DatagramKind::samples) {
        EXPECT_EQ(received.kind, DatagramKind::goodbye);
        return last;
      }
      last = received.batch.samples[0];
      answer(last);
    }
  }
  void push_back(const Sample& sample) {
    peer.send(ScenePeer::reply_to(sample, {.elastic = Vec3(0, 0, 3)}));
  }
};

/// Between two rows the force must not fall faster than 3 N in half the hold time. On a machine
/// that stalls, no tick need come before the newest reply begins to fade: the largest force may be
/// less than 3 N.
void expect_no_step_down(Ring<TickRecord>& records) {
  const double fastest = 3.0 / (0.5 * SessionParameters{}.hold_time);  // [N/s]
  TickRecord row, before;
  bool first = true;
  double most = 0.0;
  while (records.pop(row)) {
    if (!first) {
      EXPECT_GE(row.held.z(), before.held.z() - fastest * (row.time - before.time) - 1e-9);
    }
    first = false;
    before = row;
    most = std::max(most, row.held.z());
  }
  EXPECT_GT(most, 0.0);
  EXPECT_LE(most, 3.0);
  EXPECT_EQ(before.held.z(), 0.0);
}

TEST(ServoLoop, EndsWithItsDurationAndLetsTheHandGo) {
  LoopRun run({.duration = std::chrono::milliseconds(60)});
  const Sample last = run.answer_until_goodbye([&](const Sample& s) { run.push_back(s); });
  run.thread.join();
  EXPECT_EQ(run.result->end, EndReason::duration);
  EXPECT_GE(run.result->duration, 0.06);
  EXPECT_EQ(run.device.largest, 3.0);
  EXPECT_EQ(run.device.last.force(), Vec3::Zero());
  EXPECT_EQ(last.held.force(), Vec3::Zero());
  const ServoStatistics& s = run.servo.statistics();
  EXPECT_EQ(last.index, s.samples);
  EXPECT_EQ(s.replies.answered, s.samples);  // The loop must wait for the last reply.
  EXPECT_EQ(s.samples,
            // one tick per kept deadline, and one for the release
            run.result->wakeup_late.count() + 1);
  EXPECT_EQ(run.transport.statistics().sent, s.samples + 3);

  std::uint64_t rows = 0;
  TickRecord row, before;
  while (run.records.pop(row)) {
    if (rows++ > 0) {
      EXPECT_GT(row.time, before.time);
    }
    before = row;
  }
  EXPECT_EQ(rows, s.samples);
  LiveStatus status;
  ASSERT_TRUE(run.statuses.pop(status));
}

/// The loop first fades the servo's own force. It then lowers the tool tick by tick, and releases
/// the device last.
TEST(ServoLoop, LetsAToolDownBeforeTheRelease) {
  LoopRun run({.duration = std::chrono::milliseconds(60)}, 1u << 20, 20);
  run.answer_until_goodbye([&](const Sample& s) { run.push_back(s); });
  run.thread.join();
  EXPECT_EQ(run.device.largest, 3.0);
  EXPECT_EQ(run.device.asked_to_lower, 21);
  EXPECT_FALSE(run.device.pulled_when_asked);
  EXPECT_GE(run.device.writes_at_release - run.device.pulled_at, 20);
  EXPECT_EQ(run.device.released, 1);
}

TEST(ServoLoop, EndsWithItsDevice) {
  LoopRun run({}, 5);
  run.answer_until_goodbye([&](const Sample& s) { run.push_back(s); });
  run.thread.join();
  EXPECT_EQ(run.result->end, EndReason::device_ended);
  EXPECT_EQ(run.servo.statistics().samples, 6u);
  EXPECT_EQ(run.device.last.force(), Vec3::Zero());
}

TEST(ServoLoop, EndsWhenAsked) {
  LoopRun run({});
  int answered = 0;
  run.answer_until_goodbye([&](const Sample& s) {
    run.push_back(s);
    if (++answered == 3) run.stop.set();
  });
  run.thread.join();
  EXPECT_EQ(run.result->end, EndReason::requested);
  EXPECT_EQ(run.device.last.force(), Vec3::Zero());
  expect_no_step_down(run.records);
}

TEST(ServoLoop, EndsWithTheServersGoodbye) {
  LoopRun run({});
  int answered = 0;
  run.answer_until_goodbye([&](const Sample& s) {
    run.push_back(s);
    if (++answered == 3) run.peer.send(GoodbyeReason::shutting_down);
  });
  run.thread.join();
  EXPECT_EQ(run.result->end, EndReason::server_goodbye);
  EXPECT_EQ(run.result->goodbye, GoodbyeReason::shutting_down);
  EXPECT_EQ(run.device.last.force(), Vec3::Zero());
  expect_no_step_down(run.records);
}

/// The loop must not wait for a device that always reports a held force.
TEST(ServoLoop, EndsWithADeviceThatDoesNotLetGo) {
  class Stuck final : public Device {
   public:
    const DeviceSpec& spec() const override { return spec_; }
    DeviceReading read(Nanoseconds) noexcept override { return {}; }
    Command write(const Command&) noexcept override { return {.elastic = Vec3(0, 0, 1)}; }
    void release() noexcept override { released = true; }
    bool released = false;

   private:
    DeviceSpec spec_ = builtin_device("simulated");
  } device;
  const ScenePeer peer;
  Transport transport(peer.session(), {}, false);
  Servo servo(device.spec(), {});
  Event stop;
  stop.set();
  const auto result = std::make_unique<LoopResult>();
  run_servo_loop(device, servo, transport, {}, stop, {}, *result);
  EXPECT_EQ(result->end, EndReason::requested);
  EXPECT_TRUE(device.released);
}

/// Replies to samples that the client never sent must not count as signs of life.
TEST(ServoLoop, RepliesToSamplesNeverSentAreSilence) {
  LoopRun run({.silence_timeout = std::chrono::milliseconds(40)});
  run.answer_until_goodbye([&](const Sample& s) {
    Sample never = s;
    never.index += 1'000'000;
    run.push_back(never);
  });
  run.thread.join();
  EXPECT_EQ(run.result->end, EndReason::server_silent);
  EXPECT_GT(run.servo.statistics().replies.refused, 0u);
  EXPECT_EQ(run.device.largest, 0.0);
}

TEST(ServoLoop, EndsWhenTheServerFallsSilent) {
  LoopRun run({.silence_timeout = std::chrono::milliseconds(40)});
  int answered = 0;
  run.answer_until_goodbye([&](const Sample& s) {
    if (++answered <= 3) run.push_back(s);
  });
  run.thread.join();
  EXPECT_EQ(run.result->end, EndReason::server_silent);
  EXPECT_GT(run.servo.statistics().samples, run.servo.statistics().replies.answered);
}

TEST(ServoLoop, AHeldUpLoopPassesOverDeadlinesInsteadOfCatchingUp) {
  // A reading takes twenty periods. The loop must skip the missed deadlines.
  class SlowOnce final : public Device {
   public:
    const DeviceSpec& spec() const override { return spec_; }
    DeviceReading read(Nanoseconds) noexcept override {
      if (++readings_ == 3) {
        const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
        while (std::chrono::steady_clock::now() < until) {
        }
      }
      return {.pose = {}, .ended = readings_ == 6};
    }
    Command write(const Command& on_hand) noexcept override { return on_hand; }
    void release() noexcept override {}

   private:
    DeviceSpec spec_ = builtin_device("simulated");
    int readings_ = 0;
  } device;
  const ScenePeer peer;
  Transport transport(peer.session(), {}, false);
  Servo servo(device.spec(), {});
  const Event stop;
  const auto result = std::make_unique<LoopResult>();
  run_servo_loop(device, servo, transport, {}, stop, {}, *result);
  EXPECT_EQ(result->end, EndReason::device_ended);
  EXPECT_EQ(servo.statistics().samples, 7u);  // The loop makes six readings and one release.
  EXPECT_GE(result->overruns, 1u);
  EXPECT_GE(result->missed_deadlines, 18u);
}

TEST(ServoLoop, RecordsThatFindNoRoomAreCounted) {
  const ScenePeer peer;
  Transport transport(peer.session(), {}, false);
  StillDevice device(10);
  Servo servo(device.spec(), {});
  const Event stop;
  const auto result = std::make_unique<LoopResult>();
  Ring<TickRecord> records(4);
  run_servo_loop(device, servo, transport, {}, stop, {.record = &records}, *result);
  EXPECT_EQ(result->records_dropped, servo.statistics().samples - 4);
}

/// Each tick and each answer is counted in exactly one class.
TEST(ServoLoop, CountsItsWakeUpsAndRoundTripsForThoseWhoLookOn) {
  LoopRun run({});
  const auto total = [](const HandTimes::Counts& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  };
  int heard = 0;
  while (heard < 2) {
    const auto got = run.peer.receive();
    ASSERT_EQ(got.kind, DatagramKind::samples);
    const Sample& sample = got.batch.samples[0];
    run.push_back(sample);
    if (!got.batch.report || !got.batch.report->times) continue;
    ++heard;
    const HandTimes& times = *got.batch.report->times;
    EXPECT_EQ(total(times.wakeups), sample.index);
    EXPECT_LT(total(times.round_trips), sample.index);
    if (heard == 2) {
      EXPECT_GT(sample.index, 1u);
      EXPECT_GT(total(times.round_trips), 0u);
    }
  }
}

/// Each session numbers its changes from 1. The loop must not report a change of the former session
/// to the next server, because both sessions use equal numbers.
TEST(ServoLoop, AChangeOfTheSessionBeforeIsNotReportedToTheNext) {
  ScenePeer first, second;
  Transport transport(first.session(), {}, false);
  StillDevice device(std::numeric_limits<std::uint64_t>::max());
  Servo servo(device.spec(), LoopRun::unbounded());
  Ring<SessionAddress> sessions(2);
  Ring<PreparedChange*> ready(4);
  PreparedChange old, own;
  old.number = 1;
  own.number = 2;
  own.session = 1;
  ASSERT_TRUE(sessions.push(second.session()));
  ASSERT_TRUE(ready.push(&old));
  const auto result = std::make_unique<LoopResult>();
  Event stop;
  const LoopOptions options{
      .patience = std::chrono::seconds(10), .rejoined = &sessions, .changes = &ready};
  std::thread thread([&] { run_servo_loop(device, servo, transport, options, stop, {}, *result); });
  bool pushed = false;
  for (auto got = second.receive(); got.kind == DatagramKind::samples; got = second.receive()) {
    if (!got.batch.report) continue;
    if (!pushed) {
      EXPECT_EQ(got.batch.report->change, 0);
      EXPECT_TRUE(ready.push(&own));
      pushed = true;
    } else if (got.batch.report->change != 0) {
      EXPECT_EQ(got.batch.report->change, 2);
      break;
    }
  }
  stop.set();
  thread.join();
  EXPECT_GE(old.taken, 0.0);
  EXPECT_GE(own.taken, 0.0);
}

}  // namespace
}  // namespace feltwire::servo_loop_test
