#pragma once

#include <atomic>

namespace feltwire {

/// A flag to wait on. Both calls are safe in any thread and in a signal handler.
class Event {
 public:
  /// Throws std::system_error when the system has no more descriptors.
  Event();
  ~Event();
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  void set() noexcept;
  bool is_set() const noexcept { return set_.load(std::memory_order_acquire); }
  /// Readable once set, for ever. Where the system fails to tell, is_set() still does.
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
  std::atomic<bool> set_{false};
};

}  // namespace feltwire
