#pragma once
// Progress and cancellation of work that takes seconds, such as loading a scene.

#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>
#include <utility>

namespace feltwire {

/// Thrown by check_cancelled(). It is not a std::exception, so that no handler mistakes it for an
/// error of the work.
struct Cancelled {};

/// The state of one piece of work. Any thread may read it and cancel the work.
class CancellableWork {
 public:
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }

  /// Starts a stage. The name is shown to people: "objects[2].mesh".
  void begin(std::string stage) {
    const std::lock_guard lock(mutex_);
    stage_ = std::move(stage);
    step_ = done_ = of_ = 0;
  }
  /// Starts the next step of the stage, which has `of` parts.
  void begin_step(std::size_t of) {
    const std::lock_guard lock(mutex_);
    ++step_;
    done_ = 0;
    of_ = of;
  }
  /// Tells how many parts of the step are done. Several threads may tell it in any order.
  void advance(std::size_t done) noexcept {
    std::size_t before = done_.load(std::memory_order_relaxed);
    while (before < done && !done_.compare_exchange_weak(before, done, std::memory_order_relaxed)) {
    }
  }
  /// The stage and its progress, which never goes back: "objects[2].mesh, 40 %", then
  /// "objects[2].mesh, step 2, 10 %".
  std::string progress() const {
    const std::lock_guard lock(mutex_);
    if (of_ == 0) return stage_;
    return stage_ + (step_ > 1 ? ", step " + std::to_string(step_) : "") + ", " +
           std::to_string(100 * done_ / of_) + " %";
  }

 private:
  std::atomic<bool> cancelled_{false};
  std::atomic<std::size_t> done_{0};
  mutable std::mutex mutex_;  // of the members below
  std::string stage_;
  std::size_t step_ = 0, of_ = 0;
};

inline thread_local CancellableWork* work_of_this_thread = nullptr;
/// The work of the calling thread. Null: the thread reports no progress and cannot be cancelled.
inline CancellableWork* current_work() noexcept { return work_of_this_thread; }

/// While this object lives, the calling thread works on `work`, and so do the threads that
/// parallel_for() starts for it.
class WorkScope {
 public:
  explicit WorkScope(CancellableWork* work) noexcept
      : before_(std::exchange(work_of_this_thread, work)) {}
  ~WorkScope() { work_of_this_thread = before_; }
  WorkScope(const WorkScope&) = delete;
  WorkScope& operator=(const WorkScope&) = delete;

 private:
  CancellableWork* before_;
};

/// Throws Cancelled if the work was cancelled. Call it every few milliseconds in long loops.
inline void check_cancelled() {
  if (const CancellableWork* work = current_work(); work != nullptr && work->cancelled())
    throw Cancelled{};
}
/// Calls check_cancelled() every 4096th time.
inline void check_cancelled(std::size_t iteration) {
  constexpr std::size_t kMask = 4095;
  if ((iteration & kMask) == 0) check_cancelled();
}
inline void begin_stage(std::string stage) {
  if (CancellableWork* work = current_work(); work != nullptr) work->begin(std::move(stage));
}

}  // namespace feltwire
