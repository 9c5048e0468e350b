#pragma once
// Releases a device whose library has no call that a signal handler may make.

#include <atomic>
#include <functional>
#include <thread>

#include "client/device/sample_mailbox.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire {

/// A thread that takes the force off on request. The library's call may block and lock, so it does
/// not run in the thread or signal handler that requests it.
class AsyncSignalRelease {
 public:
  /// `take_off` must not throw. Throws std::system_error if the system gives no thread.
  explicit AsyncSignalRelease(std::function<void()> take_off)
      : take_off_(std::move(take_off)), thread_([this] { run(); }) {}
  ~AsyncSignalRelease() {
    over_.store(true);
    wake_.set();
    thread_.join();
  }
  AsyncSignalRelease(const AsyncSignalRelease&) = delete;
  AsyncSignalRelease& operator=(const AsyncSignalRelease&) = delete;

  /// For any thread and any signal handler. Each call takes the force off once more.
  void now() noexcept {
    asked_.store(true);
    wake_.set();
  }
  bool asked() const noexcept { return asked_.load(); }

 private:
  void run() {
    // Above the servo thread, as its watch is: it is asked when the servo thread stands still.
    request_real_time(kServoPriority + 1);
    while (!over_.load()) {
      wake_.wait();
      if (asked_.load()) take_off_();
    }
  }

  std::function<void()> take_off_;
  Wake wake_;
  std::atomic<bool> asked_{false}, over_{false};
  std::thread thread_;
};

}  // namespace feltwire
