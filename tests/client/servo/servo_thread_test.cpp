// If a servo thread stops, ends or crashes, the program must release the device.

#include "client/servo/servo_thread.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <functional>
#include <semaphore>

#include "client/device/async_signal_release.hpp"
#include "client/run/crash_release.hpp"
#include "client/servo/stall_detector.hpp"
#include "tests/client/peer.hpp"

namespace feltwire::servo_thread_test {
namespace {

using testing::ScenePeer;
using Verdict = StallDetector::Verdict;

constexpr Nanoseconds kLate = std::chrono::milliseconds(5), kHold = std::chrono::milliseconds(100);
constexpr Nanoseconds kTick = std::chrono::milliseconds(1);

/// Calls the stall detector as its thread does, late by a given time. The servo thread ticks until
/// it stalls.
struct Looks {
  StallDetector watch{kLate, kHold};
  Nanoseconds now = std::chrono::hours(3);
  StallDetector::SignsOfLife life{.calls = 1, .tick = now, .pulls = true};

  Verdict look(Nanoseconds late = {}) {
    now += watch.pause() + late;
    return watch.look(now, life);
  }
  /// Lets the servo thread tick in each period until the check.
  Verdict look_at_ticks(Nanoseconds late = {}) {
    now += watch.pause() + late;
    for (; life.tick + kTick <= now; life.tick += kTick) life.calls += 2;
    return watch.look(now, life);
  }
  /// Returns the time from the newest tick to the verdict of a stall. Each check is late by `late`.
  Nanoseconds until_it_stands_still(Nanoseconds late = {}) {
    while (look(late) == Verdict::ticks && now < life.tick + std::chrono::minutes(1)) continue;
    return now - life.tick;
  }
};

TEST(StallDetector, LetsGoWhenATickIsLateBySomePeriods) {
  Looks looks;
  for (int n = 0; n < 1000; ++n) ASSERT_EQ(looks.look_at_ticks(), Verdict::ticks);
  EXPECT_EQ(looks.until_it_stands_still(), kLate);
  EXPECT_EQ(looks.watch.still(), kLate);
  const Nanoseconds still = looks.now;
  while (looks.look() == Verdict::stands_still) continue;
  EXPECT_EQ(looks.now - still, StallDetector::kGrace);
  ++looks.life.calls;
  EXPECT_EQ(looks.look(), Verdict::gone);  // A later tick must not change the verdict.
}

/// A shorter delay is no stall, even if such delays are frequent.
TEST(StallDetector, LateTicksThatComeAreNoStandstill) {
  Looks looks;
  Nanoseconds next = looks.now;
  for (int n = 0; n < 1000; ++n) {
    const Nanoseconds wake = looks.now + looks.watch.pause();
    for (; next <= wake; next += kLate - std::chrono::microseconds(1)) {
      looks.life.tick = next;
      looks.life.calls += 2;
    }
    looks.now = wake;
    ASSERT_EQ(looks.watch.look(looks.now, looks.life), Verdict::ticks) << n;
  }
}

/// Each read() returns, but late.
TEST(StallDetector, ACallThatAlwaysTakesLongIsFound) {
  Looks looks;
  ASSERT_EQ(looks.look_at_ticks(), Verdict::ticks);
  looks.life.calls += 1;  // The write after a read of 20 ms returned, and the next read began.
  looks.life.tick = looks.now;
  EXPECT_EQ(looks.until_it_stands_still(), kLate);
}

/// The stall detector wakes once in several ticks.
TEST(StallDetector, LooksSeldom) {
  Looks looks;
  const Nanoseconds began = looks.now;
  for (int n = 0; n < 1000; ++n) ASSERT_EQ(looks.look_at_ticks(), Verdict::ticks);
  EXPECT_GE((looks.now - began) / 1000, kLate - kTick);
}

/// Late checks must not add up. Only the last check may delay the verdict.
TEST(StallDetector, AWatchThatIsWokenLateIsLateOnlyOnce) {
  for (const int late : {100, 1000, 3000, 5000}) {
    const Nanoseconds by = std::chrono::microseconds(late);
    Looks looks;
    for (int n = 0; n < 5; ++n) ASSERT_EQ(looks.look_at_ticks(by), Verdict::ticks);
    const Nanoseconds took = looks.until_it_stands_still(by);
    EXPECT_GE(took, kLate) << late;
    EXPECT_LE(took, kLate + by) << late;
  }
}

/// The complete program was stopped. The servo thread gets time for a tick, but only once.
TEST(StallDetector, AProgramThatWasStoppedAsAWholeGoesOn) {
  Looks looks;
  ASSERT_EQ(looks.look_at_ticks(), Verdict::ticks);
  ASSERT_EQ(looks.look(std::chrono::seconds(20)), Verdict::ticks);
  ASSERT_EQ(looks.look_at_ticks(), Verdict::ticks);
  ASSERT_EQ(looks.look(std::chrono::seconds(20)), Verdict::ticks);
  const Nanoseconds woke = looks.now;
  looks.until_it_stands_still();
  EXPECT_EQ(looks.now - woke, kLate);
  Looks starved;  // The stall detector always wakes late.
  ASSERT_EQ(starved.look_at_ticks(), Verdict::ticks);
  ASSERT_EQ(starved.look(4 * kLate), Verdict::ticks);
  EXPECT_EQ(starved.look(4 * kLate), Verdict::stands_still);
  Looks ticked;  // The thread ticked between the last check and the stop.
  ASSERT_EQ(ticked.look_at_ticks(), Verdict::ticks);
  ticked.life.tick = ticked.now;
  ticked.life.calls += 2;
  ASSERT_EQ(ticked.look(std::chrono::seconds(20)), Verdict::ticks);
  const Nanoseconds thawed = ticked.now;
  ticked.until_it_stands_still();
  EXPECT_EQ(ticked.now - thawed, kLate);
}

TEST(StallDetector, WaitsLongerWhereNothingIsHeld) {
  Looks looks;
  looks.life.pulls = false;
  ASSERT_EQ(looks.look_at_ticks(), Verdict::ticks);
  EXPECT_GE(looks.until_it_stands_still(), StallDetector::kIdle);
  EXPECT_LE(looks.now - looks.life.tick, StallDetector::kIdle + kLate);
}

/// Without a device tick the servo itself removes the force.
TEST(StallDetector, ATickOfTheDeviceIsWaitedForAsLongAsTheServoDoes) {
  Looks looks;
  looks.life.awaits = true;
  ASSERT_EQ(looks.look_at_ticks(), Verdict::ticks);
  const Nanoseconds took = looks.until_it_stands_still();
  EXPECT_GE(took, kHold);
  EXPECT_LE(took, kHold + kLate);
}

TEST(StallDetector, AForceThatComesLateIsHeldNoLonger) {
  Looks looks;
  looks.life.pulls = false;
  for (int n = 0; n < 50; ++n) ASSERT_EQ(looks.look(), Verdict::ticks);
  looks.life.pulls = true;  // This write does not return.
  const Nanoseconds began = looks.now;
  looks.until_it_stands_still();
  EXPECT_LE(looks.now - began, kLate);
}

TEST(StallDetector, TheTimeIsAFewPeriodsUnlessTheUserHasAnother) {
  EXPECT_DOUBLE_EQ(let_go_time(1e-3, 0.1, 0.0, true), 5e-3);
  EXPECT_DOUBLE_EQ(let_go_time(1e-3, 0.1, 0.0, false), 20e-3);
  EXPECT_DOUBLE_EQ(let_go_time(1e-4, 0.1, 0.0, true), 5e-4);
  EXPECT_DOUBLE_EQ(let_go_time(1e-3, 0.1, 0.03, true), 0.03);
  EXPECT_DOUBLE_EQ(let_go_time(1e-3, 0.1, 1.0, true), 0.1);    // at most the hold time
  EXPECT_DOUBLE_EQ(let_go_time(1e-3, 0.1, 1e-5, true), 2e-3);  // at least two periods
  EXPECT_DOUBLE_EQ(let_go_time(0.1, 0.1, 0.0, true), 0.2);
}

/// A driver that keeps the last force. It calls a function of the test in read() or write().
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
  /// The guard must block later writes, because this driver does not block them.
  void release() noexcept override { told.store(0.0); }

  std::function<void()> in_read, in_write;
  std::atomic<double> told{0.0};  // [N]

 private:
  DeviceSpec spec_ = builtin_device("simulated");
};

const Command kPull{.elastic = Vec3(0, 0, 2)};

TEST(GuardedDevice, PassesOnUntilItIsReleased) {
  Driver driver;
  GuardedDevice guard(driver);
  EXPECT_FALSE(guard.pulls());
  EXPECT_EQ(guard.write(kPull).elastic.z(), 2.0);
  EXPECT_TRUE(guard.pulls());
  EXPECT_EQ(guard.writes(), 1u);
  EXPECT_TRUE(guard.read(kTick).ok);
  EXPECT_EQ(guard.calls(), 2u);
  EXPECT_EQ(guard.tick(), kTick);
  guard.release();
  EXPECT_EQ(driver.told, 0.0);
  EXPECT_FALSE(guard.pulls());
  EXPECT_EQ(guard.write(kPull).force(), Vec3::Zero());
  EXPECT_EQ(driver.told, 0.0);
  EXPECT_TRUE(guard.read({}).ended);
  EXPECT_FALSE(guard.read({}).ok);
}

TEST(GuardedDevice, AWriteThatWasUnderWayIsTakenBack) {
  Driver driver;
  GuardedDevice guard(driver);
  driver.in_write = [&] { guard.release(); };
  EXPECT_EQ(guard.write(kPull).force(), Vec3::Zero());
  EXPECT_EQ(driver.told, 0.0);
}

/// The last force stays on the hand until the zero write returns.
TEST(GuardedDevice, PullsWhileTheForceIsBeingTakenOff) {
  Driver driver;
  GuardedDevice guard(driver);
  guard.write(kPull);
  bool pulled = false;
  driver.in_write = [&] { pulled = guard.pulls(); };
  guard.write({});
  EXPECT_TRUE(pulled);
  EXPECT_FALSE(guard.pulls());
}

/// Runs a loop in a thread. A peer commands 3 N until the device blocks.
struct StuckRun {
  ScenePeer peer;
  Driver* driver = new Driver;
  std::shared_ptr<ServoTask> task;
  /// The thread may outlive the test, so both share this state.
  struct Turns {
    std::binary_semaphore stuck{0}, go_on{0};
    std::atomic<bool> taken{false};
  };
  std::shared_ptr<Turns> turns = std::make_shared<Turns>();

  StuckRun() {
    SessionParameters p;
    p.mode = "none";
    p.hold_time = 1.0;  // [s] longer than a busy machine delays a thread
    task = std::make_shared<ServoTask>(std::unique_ptr<Device>(driver),
                                       std::make_shared<Transport>(peer.session(), p, false), p,
                                       ServoOptions{});
    task->let_go_after = p.hold_time;
  }
  /// Returns a function that blocks the first read or write after a force.
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
  void expect_let_go(ServoThread& thread, DeviceCall in) {
    while (!thread.over()) std::this_thread::yield();
    EXPECT_FALSE(thread.end());
    EXPECT_EQ(task->result.still_in, in);
    EXPECT_GE(task->result.still_for, task->result.let_go_after);
    EXPECT_EQ(driver->told, 0.0);
    EXPECT_EQ(task->result.end, EndReason::failed);
    EXPECT_TRUE(task->result.stood_still);
    turns->go_on.release();  // The guard must now block further writes permanently.
    EXPECT_EQ(driver->told, 0.0);
  }
};

TEST(ServoThread, ADeviceThatDoesNotReadIsLetGo) {
  StuckRun run;
  run.driver->in_read = run.block();
  ServoThread thread(run.task);
  run.answer_until_stuck();
  EXPECT_EQ(run.driver->told, 3.0);
  run.expect_let_go(thread, DeviceCall::read);
}

TEST(ServoThread, ADeviceThatDoesNotWriteIsLetGo) {
  StuckRun run;
  run.driver->in_write = run.block();
  ServoThread thread(run.task);
  run.answer_until_stuck();
  EXPECT_EQ(run.driver->told, 3.0);
  run.expect_let_go(thread, DeviceCall::write);
}

/// A thread returns after the hold time, but in time for an orderly end. It must get no more force,
/// and the run must fail.
TEST(ServoThread, AThreadThatComesBackLateEndsWithoutForce) {
  StuckRun run;
  run.driver->in_write = run.block();
  ServoThread thread(run.task);
  run.answer_until_stuck();
  // The stall detector has released the device.
  while (run.driver->told != 0.0) std::this_thread::yield();
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

/// Keeps the last force in memory that outlives the process.
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

#ifndef FELTWIRE_SANITIZED  // A sanitizer has its own signal handlers.
TEST(CrashReleaseDeathTest, ACrashTakesTheForceOffAndStaysACrash) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGUSR1, SIGALRM}) {
    SharedDevice device;
    EXPECT_EXIT(
        {
          GuardedDevice guard(device);
          const CrashRelease release(guard);
          guard.write(kPull);
          ::raise(signal);
        },
        ::testing::KilledBySignal(signal), "");
    EXPECT_EQ(device.told(), 0.0) << signal;
  }
}

/// Returns true for signals with a default action that ends the program.
bool ends_programs(int signal) {
  constexpr std::array kOthers = {SIGKILL,  SIGSTOP, SIGCHLD, SIGCONT, SIGURG,
                                  SIGWINCH, SIGTSTP, SIGTTIN, SIGTTOU, SIGXFSZ};
  return std::ranges::find(kOthers, signal) == kOthers.end();
}

/// Another process sends the signal, as `kill -NUMBER` does. The C library reserves signals 32 and
/// 33, so the device keeps its force.
TEST(CrashReleaseDeathTest, EverySignalThatEndsTheProgramTakesTheForceOff) {
  for (int signal = 1; signal <= 64; ++signal) {
    if (!ends_programs(signal)) continue;
    const bool own = signal >= 32 && signal < SIGRTMIN;
    SharedDevice device;
    EXPECT_EXIT(
        {
          // The test's parent may ignore some signals.
          if (!own) ::signal(signal, SIG_DFL);
          GuardedDevice guard(device);
          const CrashRelease release(guard);
          guard.write(kPull);
          ::syscall(SYS_tgkill, ::getpid(), ::syscall(SYS_gettid), signal);
          std::_Exit(own ? 7 : 8);
        },
        [&](int status) {
          return own ? WIFEXITED(status) && WEXITSTATUS(status) == 7
                     : WIFSIGNALED(status) && WTERMSIG(status) == signal;
        },
        "")
        << signal;
    EXPECT_EQ(device.told() > 0.0, own) << signal;
  }
}

/// The signal handler of another part of the program stays in use. All handlers are restored
/// afterwards.
TEST(CrashReleaseDeathTest, AHandledSignalStaysHandled) {
  SharedDevice device;
  EXPECT_EXIT(
      {
        ::signal(SIGRTMIN + 3, [](int) { std::_Exit(7); });
        ::signal(SIGPIPE, SIG_IGN);
        { const CrashRelease release(device); }
        const CrashRelease release(device);
        ::raise(SIGPIPE);
        ::raise(SIGRTMIN + 3);
      },
      ::testing::ExitedWithCode(7), "");
  EXPECT_EXIT(
      {
        { const CrashRelease release(device); }
        ::raise(SIGIO);
      },
      ::testing::KilledBySignal(SIGIO), "");
}

TEST(CrashReleaseDeathTest, ExitTakesTheForceOff) {
  SharedDevice device;
  EXPECT_EXIT(
      {
        GuardedDevice guard(device);
        const CrashRelease release(guard);
        guard.write(kPull);
        std::exit(3);
      },
      ::testing::ExitedWithCode(3), "");
  EXPECT_EQ(device.told(), 0.0);
}

/// The devices are the parent's.
TEST(CrashReleaseDeathTest, AChildProcessReleasesNothing) {
  SharedDevice device;
  EXPECT_EXIT(
      {
        const CrashRelease release(device);
        device.write(kPull);
        const pid_t child = ::fork();
        if (child == 0) ::raise(SIGTERM);
        int status = 0;
        ::waitpid(child, &status, 0);
        std::_Exit(WIFSIGNALED(status) ? 5 : 6);
      },
      ::testing::ExitedWithCode(5), "");
  EXPECT_GT(device.told(), 0.0);
}

TEST(CrashReleaseDeathTest, AHandlerThatTheProgramSetsMeanwhileStays) {
  SharedDevice device;
  EXPECT_EXIT(
      {
        {
          const CrashRelease release(device);
          ::signal(SIGTERM, [](int) { std::_Exit(9); });
        }
        ::raise(SIGTERM);
      },
      ::testing::ExitedWithCode(9), "");
}

TEST(CrashReleaseDeathTest, AllDevicesOfTheProcessAreReleased) {
  SharedDevice first, second, third;
  EXPECT_EXIT(
      {
        const CrashRelease release_first(first);
        auto release_second = std::make_unique<CrashRelease>(second);
        const CrashRelease release_third(third);
        for (SharedDevice* device : {&first, &second, &third}) device->write(kPull);
        release_second.reset();
        ::raise(SIGSEGV);
      },
      ::testing::KilledBySignal(SIGSEGV), "");
  EXPECT_EQ(first.told(), 0.0);
  EXPECT_GT(second.told(), 0.0);
  EXPECT_EQ(third.told(), 0.0);
}

/// The driver's library has no call that is safe in a signal handler. The thread of the driver must
/// remove the force.
class LettingGoDevice final : public Device {
 public:
  explicit LettingGoDevice(SharedDevice& device)
      : device_(device), let_go_([this] { device_.write({}); }) {}
  const DeviceSpec& spec() const override { return device_.spec(); }
  DeviceReading read(Nanoseconds) noexcept override { return {}; }
  Command write(const Command& on_hand) noexcept override { return device_.write(on_hand); }
  void release() noexcept override { let_go_.now(); }

 private:
  SharedDevice& device_;
  AsyncSignalRelease let_go_;
};

TEST(CrashReleaseDeathTest, AThreadOfTheDriverHasTheTimeToLetGo) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGIO, SIGRTMAX}) {
    SharedDevice device;
    EXPECT_EXIT(
        {
          LettingGoDevice letting_go(device);
          const CrashRelease release(letting_go);
          letting_go.write(kPull);
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
        GuardedDevice guard(device);
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
