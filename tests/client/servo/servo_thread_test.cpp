// A servo thread that stands still, dies or crashes lets the device go.

#include "client/servo/servo_thread.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <csignal>
#include <functional>
#include <semaphore>

#include "client/run/crash_release.hpp"
#include "client/servo/tick_watch.hpp"
#include "tests/client/peer.hpp"

namespace feltwire::servo_thread_test {
namespace {

using testing::ScenePeer;
using Verdict = TickWatch::Verdict;

constexpr Nanoseconds kHold = std::chrono::milliseconds(100);
constexpr Nanoseconds kInterval = kHold / TickWatch::kLooks;

/// Looks as the watch of a servo thread does, and is woken late as it is told.
struct Looks {
  TickWatch watch{kHold};
  Nanoseconds now = std::chrono::hours(3);
  std::uint64_t ticks = 1;

  Verdict look(bool pulls = true, Nanoseconds late = {}) {
    now += watch.pause() + late;
    return watch.look(now, ticks, pulls);
  }
  /// The time from now to the verdict that it stands still, if each look is that late.
  Nanoseconds until_it_stands_still(bool pulls = true, Nanoseconds late = {}) {
    const Nanoseconds began = now;
    while (look(pulls, late) == Verdict::ticks && now < began + std::chrono::minutes(1)) continue;
    return now - began;
  }
};

/// The tick came at most one interval before the look that saw it; one is left to wake threads in.
TEST(TickWatch, LetsGoWithinTheHoldTimeOfTheLastTick) {
  Looks looks;
  for (int n = 0; n < 1000; ++n, ++looks.ticks) ASSERT_EQ(looks.look(), Verdict::ticks);
  --looks.ticks;
  EXPECT_EQ(looks.until_it_stands_still(), kHold - 2 * kInterval);
  const Nanoseconds still = looks.now;
  while (looks.look() == Verdict::stands_still) continue;
  EXPECT_EQ(looks.now - still, TickWatch::kGrace);
  ++looks.ticks;
  EXPECT_EQ(looks.look(), Verdict::gone);  // a tick then changes nothing
}

/// What each look is late by does not add up: only the last one counts.
TEST(TickWatch, AWatchThatIsWokenLateIsLateOnlyOnce) {
  for (const int late : {1, 5, 13, 30}) {
    const Nanoseconds by = std::chrono::milliseconds(late);
    Looks looks;
    ASSERT_EQ(looks.look(true, by), Verdict::ticks);
    const Nanoseconds took = looks.until_it_stands_still(true, by);
    EXPECT_GE(took, kHold - 2 * kInterval) << late;
    EXPECT_LE(took, kHold - 2 * kInterval + by) << late;
  }
}

/// It was stopped together with the servo thread, which gets time to tick.
TEST(TickWatch, AProgramThatWasStoppedAsAWholeGoesOn) {
  Looks looks;
  ASSERT_EQ(looks.look(), Verdict::ticks);
  ASSERT_EQ(looks.look(true, std::chrono::seconds(20)), Verdict::ticks);
  const Nanoseconds left = kHold - 2 * kInterval - TickWatch::kMostCounted * kInterval;
  EXPECT_EQ(looks.until_it_stands_still(), left);
}

TEST(TickWatch, WaitsLongerWhereNothingIsHeld) {
  Looks looks;
  ASSERT_EQ(looks.look(false), Verdict::ticks);
  EXPECT_EQ(looks.until_it_stands_still(false), TickWatch::kIdle);
}

TEST(TickWatch, AForceThatComesLateIsHeldNoLonger) {
  Looks looks;
  for (int n = 0; n < 50; ++n) ASSERT_EQ(looks.look(false), Verdict::ticks);
  EXPECT_EQ(looks.until_it_stands_still(), kHold - 2 * kInterval);
}

/// Holds what it was told last, and has the test do something in the middle of read() or write().
class Driver final : public Device {
 public:
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override {
    if (in_read) in_read();
    return {};
  }
  Command write(const Command& on_hand) noexcept override {
    if (in_write) in_write();
    told.store(on_hand.force().norm());
    return on_hand;
  }
  /// Does not latch, although it should: the guard does.
  void release() noexcept override { told.store(0.0); }

  std::function<void()> in_read, in_write;
  std::atomic<double> told{0.0};  // [N]

 private:
  DeviceSpec spec_ = builtin_device("simulated");
};

const Command kPull{.elastic = Vec3(0, 0, 2)};

TEST(DeviceGuard, PassesOnUntilItIsReleased) {
  Driver driver;
  DeviceGuard guard(driver);
  EXPECT_FALSE(guard.pulls());
  EXPECT_EQ(guard.write(kPull).elastic.z(), 2.0);
  EXPECT_TRUE(guard.pulls());
  EXPECT_EQ(guard.writes(), 1u);
  EXPECT_TRUE(guard.read({}).ok);
  guard.release();
  EXPECT_EQ(driver.told, 0.0);
  EXPECT_FALSE(guard.pulls());
  EXPECT_EQ(guard.write(kPull).force(), Vec3::Zero());
  EXPECT_EQ(driver.told, 0.0);
  EXPECT_TRUE(guard.read({}).ended);
  EXPECT_FALSE(guard.read({}).ok);
}

TEST(DeviceGuard, AWriteThatWasUnderWayIsTakenBack) {
  Driver driver;
  DeviceGuard guard(driver);
  driver.in_write = [&] { guard.release(); };
  EXPECT_EQ(guard.write(kPull).force(), Vec3::Zero());
  EXPECT_EQ(driver.told, 0.0);
}

/// The last force is on the hand until the write of none has come back.
TEST(DeviceGuard, PullsWhileTheForceIsBeingTakenOff) {
  Driver driver;
  DeviceGuard guard(driver);
  guard.write(kPull);
  bool pulled = false;
  driver.in_write = [&] { pulled = guard.pulls(); };
  guard.write({});
  EXPECT_TRUE(pulled);
  EXPECT_FALSE(guard.pulls());
}

/// A thread whose loop gets 3 N from a peer until its device stops answering.
struct StuckRun {
  ScenePeer peer;
  Driver* driver = new Driver;
  std::shared_ptr<ServoTask> task;
  /// The thread may outlive the test.
  struct Turns {
    std::binary_semaphore stuck{0}, go_on{0};
    std::atomic<bool> taken{false};
  };
  std::shared_ptr<Turns> turns = std::make_shared<Turns>();

  StuckRun() {
    SessionParameters p;
    p.mode = "none";
    p.hold_time = 1.0;  // longer than a busy machine keeps a thread waiting
    task = std::make_shared<ServoTask>(std::unique_ptr<Device>(driver),
                                       std::make_shared<Transport>(peer.session(), p, false), p,
                                       ServoOptions{});
  }
  /// From the first force on the next read or write does not come back.
  std::function<void()> block() {
    return [turns = turns, driver = driver] {
      if (driver->told.load() == 0.0 || turns->taken.exchange(true)) return;
      turns->stuck.release();
      turns->go_on.acquire();
    };
  }
  void answer_until_stuck() {
    while (!turns->stuck.try_acquire()) {
      if (!peer.has_datagram()) continue;
      const auto received = peer.receive();
      if (received.kind == DatagramKind::samples)
        peer.send(ScenePeer::reply_to(received.batch.samples[0], {.elastic = Vec3(0, 0, 3)}));
    }
  }
  void expect_let_go(ServoThread& thread) {
    while (!thread.over()) std::this_thread::yield();
    EXPECT_FALSE(thread.end());
    EXPECT_EQ(driver->told, 0.0);
    EXPECT_EQ(task->result.end, EndReason::failed);
    EXPECT_TRUE(task->result.stood_still);
    turns->go_on.release();  // to stop for good in the guard
    EXPECT_EQ(driver->told, 0.0);
  }
};

TEST(ServoThread, ADeviceThatDoesNotReadIsLetGo) {
  StuckRun run;
  run.driver->in_read = run.block();
  ServoThread thread(run.task);
  run.answer_until_stuck();
  EXPECT_EQ(run.driver->told, 3.0);
  run.expect_let_go(thread);
}

TEST(ServoThread, ADeviceThatDoesNotWriteIsLetGo) {
  StuckRun run;
  run.driver->in_write = run.block();
  ServoThread thread(run.task);
  run.answer_until_stuck();
  EXPECT_EQ(run.driver->told, 3.0);
  run.expect_let_go(thread);
}

/// One that comes back in time for a proper end, but later than the hold time, gets no force any
/// more, and has failed.
TEST(ServoThread, AThreadThatComesBackLateEndsWithoutForce) {
  StuckRun run;
  run.driver->in_write = run.block();
  ServoThread thread(run.task);
  run.answer_until_stuck();
  while (run.driver->told != 0.0) std::this_thread::yield();  // the watch has let go
  run.turns->go_on.release();
  EXPECT_TRUE(thread.end());
  EXPECT_EQ(run.driver->told, 0.0);
  EXPECT_EQ(run.task->result.end, EndReason::failed);
  EXPECT_TRUE(run.task->result.stood_still);
}

TEST(ServoThread, EndsWhenAskedAndLeavesTheDeviceReleased) {
  StuckRun run;
  ServoThread thread(run.task);
  EXPECT_TRUE(thread.end());
  EXPECT_TRUE(thread.over());
  EXPECT_TRUE(run.task->guard.released());
  EXPECT_EQ(run.task->result.end, EndReason::requested);
  EXPECT_FALSE(run.task->result.stood_still);
}

/// Says in memory that outlives the process what it was told last.
class SharedDevice final : public Device {
 public:
  SharedDevice()
      : force_(static_cast<std::atomic<double>*>(::mmap(
            nullptr, sizeof(double), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {}
  ~SharedDevice() override { ::munmap(force_, sizeof(double)); }
  SharedDevice(const SharedDevice&) = delete;
  SharedDevice& operator=(const SharedDevice&) = delete;
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override { return {}; }
  Command write(const Command& on_hand) noexcept override {
    force_->store(on_hand.force().norm());
    return on_hand;
  }
  void release() noexcept override { force_->store(0.0); }
  double told() const { return force_->load(); }

 private:
  DeviceSpec spec_ = builtin_device("simulated");
  std::atomic<double>* force_;
};

#ifndef FELTWIRE_SANITIZED  // whose handlers are their own
TEST(CrashReleaseDeathTest, ACrashTakesTheForceOffAndStaysACrash) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGUSR1, SIGALRM}) {
    SharedDevice device;
    EXPECT_EXIT(
        {
          DeviceGuard guard(device);
          const CrashRelease release(guard);
          guard.write(kPull);
          ::raise(signal);
        },
        ::testing::KilledBySignal(signal), "");
    EXPECT_EQ(device.told(), 0.0) << signal;
  }
}

TEST(CrashReleaseDeathTest, AnExceptionThatNobodyCatchesTakesTheForceOff) {
  SharedDevice device;
  EXPECT_EXIT(
      {
        DeviceGuard guard(device);
        const CrashRelease release(guard);
        guard.write(kPull);
        std::thread([] { throw std::bad_alloc(); }).join();
      },
      ::testing::KilledBySignal(SIGABRT), "bad_alloc");
  EXPECT_EQ(device.told(), 0.0);
}

TEST(CrashReleaseDeathTest, StopsFromATerminalAreIgnored) {
  SharedDevice device;
  EXPECT_EXIT(
      {
        const CrashRelease release(device);
        for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU, SIGXFSZ}) ::raise(signal);
        std::_Exit(7);
      },
      ::testing::ExitedWithCode(7), "");
}
#endif

}  // namespace
}  // namespace feltwire::servo_thread_test
