#pragma once
// Work in a thread of its own, whose owner never waits for it.

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <type_traits>
#include <utility>

#include "core/base/cancellation.hpp"

namespace feltwire {

/// Runs `task` in a new thread, with `work` as the thread's work (core/base/cancellation.hpp). A
/// thread that still runs when the process ends is cancelled, and the end of the process waits for
/// it: the exit handlers of OpenSSL free what a thread may still use. That wait is bounded, because
/// to look up a name can take many seconds and cannot be cancelled. Throws std::system_error or
/// std::bad_alloc if there is no thread, and std::runtime_error once the process ends.
void run_in_background(std::shared_ptr<CancellableWork> work, std::function<void()> task);

/// A call in a background thread. The call must own all that it uses. An owner that goes away
/// cancels it.
template <class Result>
class BackgroundWork {
 public:
  /// No work.
  BackgroundWork() = default;
  /// Starts the call. Throws as run_in_background() does.
  template <class Call>
  requires std::is_invocable_r_v<Result, Call>
  explicit BackgroundWork(Call call) : work_(std::make_shared<CancellableWork>()) {
    auto task = std::make_shared<std::packaged_task<Result()>>(std::move(call));
    result_ = task->get_future();
    run_in_background(work_, [task] { (*task)(); });
  }
  ~BackgroundWork() { cancel(); }
  BackgroundWork(BackgroundWork&&) noexcept = default;
  BackgroundWork& operator=(BackgroundWork&& other) noexcept {
    cancel();
    work_ = std::move(other.work_);
    result_ = std::move(other.result_);
    return *this;
  }

  /// Whether a call was started whose result was not taken.
  bool valid() const noexcept { return result_.valid(); }
  /// Precondition: valid().
  bool is_ready() const {
    return result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  /// Takes the result. Throws what the call threw; Cancelled, once the process ends. Precondition:
  /// valid().
  Result get() { return result_.get(); }

 private:
  void cancel() noexcept {
    if (work_ != nullptr) work_->cancel();
  }

  std::shared_ptr<CancellableWork> work_;
  std::future<Result> result_;
};

}  // namespace feltwire
