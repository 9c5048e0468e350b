#pragma once

#include <atomic>

#include "core/base/event_descriptor.hpp"

namespace feltwire {

/// A flag to wait on. Both calls are safe in any thread and in a signal handler. The constructor
/// throws std::system_error if the system has no more descriptors.
class Event {
 public:
  void set() noexcept {
    set_.store(true, std::memory_order_release);
    signal_.signal();
  }
  bool is_set() const noexcept { return set_.load(std::memory_order_acquire); }
  /// Readable for ever once it is set. If the system fails to signal it, is_set() still works.
  int descriptor() const noexcept { return signal_.get(); }

 private:
  EventDescriptor signal_;
  std::atomic<bool> set_{false};
};

}  // namespace feltwire
