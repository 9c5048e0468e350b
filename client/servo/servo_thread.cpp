#include "client/servo/servo_thread.hpp"

#include <chrono>
#include <utility>

#include "client/servo/stall_detector.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {

struct ServoThread::Shared {
  explicit Shared(std::shared_ptr<ServoTask> what)
      : task(std::move(what)),
        servo_period(task->servo.parameters().servo_period),
        hold_time(task->servo.parameters().hold_time) {}

  std::shared_ptr<ServoTask> task;
  // [s] Initial values; a new law may change them in the servo.
  const double servo_period, hold_time;
  Event stop, over_event;
  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  RealTime real_time;
  bool started = false, ended = false, given_up = false;  // guarded by the mutex
  std::atomic<bool> stood_still{false};
  // The watch thread writes these values before it sets stood_still.
  std::atomic<double> still_for{0.0};
  std::atomic<DeviceCall> still_in{DeviceCall::none};
  std::atomic<double> let_go_after{0.0};

  void tell(LoopResult& result) const noexcept {
    result.let_go_after = let_go_after.load();
    if (!stood_still.load()) return;
    result.stood_still = true;
    result.still_for = still_for.load();
    result.still_in = still_in.load();
  }

  void change(bool Shared::*what) noexcept {
    {
      const std::lock_guard lock(mutex);
      this->*what = true;
    }
    changed.notify_all();
  }
};

ServoThread::ServoThread(std::shared_ptr<ServoTask> task)
    : shared_(std::make_shared<Shared>(std::move(task))) {
  watch_ = std::thread([shared = shared_] { watch(*shared); });
  try {
    servo_ = std::thread([shared = shared_] { run_loop(*shared); });
  } catch (...) {
    shared_->change(&Shared::ended);
    watch_.join();
    throw;
  }
}

ServoThread::~ServoThread() { end(); }

void ServoThread::run_loop(Shared& shared) noexcept {
  ServoTask& task = *shared.task;
  if (task.priority != ServoTask::kNoRealTime) shared.real_time = request_real_time(task.priority);
  shared.change(&Shared::started);
  run_servo_loop(task.guard, task.servo, *task.transport, task.options, shared.stop, task.outputs,
                 task.result);
  if (shared.stood_still.load()) task.result.end = EndReason::failed;
  shared.tell(task.result);
  shared.change(&Shared::ended);
  shared.over_event.set();
}

void ServoThread::watch(Shared& shared) noexcept {
  ServoTask& task = *shared.task;
  // The watch thread needs a higher priority than the servo thread. A servo thread that never
  // sleeps would block it otherwise.
  if (task.priority > 0) request_real_time(task.priority + 1);
  std::unique_lock lock(shared.mutex);
  shared.changed.wait(lock, [&] { return shared.started || shared.ended; });
  const double late = let_go_time(shared.servo_period, shared.hold_time, task.let_go_after,
                                  shared.real_time.scheduler);
  shared.let_go_after.store(late);
  StallDetector watch(from_seconds(late), from_seconds(shared.hold_time));
  watch.look(monotonic_now(), {});  // starts to count the stall time
  while (!shared.ended) {
    if (shared.changed.wait_for(lock, watch.pause(), [&] { return shared.ended; })) return;
    // The servo loop has released the device and waits only for answers.
    if (task.guard.released() && !shared.stood_still.load()) continue;
    const DeviceCall call = task.guard.call();
    switch (watch.look(monotonic_now(), {.calls = task.guard.calls(),
                                         .tick = task.guard.tick(),
                                         .pulls = task.guard.pulls(),
                                         .awaits = call == DeviceCall::await_tick})) {
      case StallDetector::Verdict::ticks:
        break;
      case StallDetector::Verdict::gone:
        if (!shared.given_up) {
          task.guard.abandon();
          shared.given_up = true;
          shared.changed.notify_all();
          shared.over_event.set();
        }
        [[fallthrough]];
      case StallDetector::Verdict::stands_still:
        if (!shared.stood_still.load()) {
          shared.still_for.store(seconds(watch.still()));
          shared.still_in.store(call);
        }
        shared.stood_still.store(true);
        task.guard.release();  // repeated, because a write may have been in progress
        break;
    }
  }
}

RealTime ServoThread::real_time() const noexcept {
  std::unique_lock lock(shared_->mutex);
  shared_->changed.wait(lock, [&] { return shared_->started; });
  return shared_->real_time;
}

void ServoThread::stop() noexcept { shared_->stop.set(); }

bool ServoThread::over() const noexcept {
  const std::lock_guard lock(shared_->mutex);
  return shared_->ended || shared_->given_up;
}

int ServoThread::over_descriptor() const noexcept { return shared_->over_event.descriptor(); }

bool ServoThread::end() noexcept {
  stop();
  {
    std::unique_lock lock(shared_->mutex);
    shared_->changed.wait(lock, [&] { return shared_->ended || shared_->given_up; });
    if (!shared_->ended) {
      shared_->tell(shared_->task->result);
      if (servo_.joinable()) servo_.detach();
      if (watch_.joinable()) watch_.detach();
      return false;
    }
  }
  if (servo_.joinable()) servo_.join();
  if (watch_.joinable()) watch_.join();
  return true;
}

}  // namespace feltwire
