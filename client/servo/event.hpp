#pragma once

#include <atomic>

namespace feltwire {

/// A flag to wait on. Both calls are safe in any thread and in a signal handler.
class Event {
 public:
  /// Throws std::system_error if the system has no more descriptors.
  Event();
  ~Event();
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  void set() noexcept;
  bool is_set() const noexcept { return set_.load(std::memory_order_acquire); }
  /// Readable for ever once it is set. If the system fails to signal it, is_set() still works.
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
  std::atomic<bool> set_{false};
};

}  // namespace feltwire
