#pragma once
// A file descriptor that one thread makes readable to wake another thread.

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace feltwire {

/// All functions but the constructor are safe in any thread and in a signal handler.
class EventDescriptor {
 public:
  /// Throws std::system_error if the system has no more descriptors.
  EventDescriptor() : descriptor_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (descriptor_ < 0)
      throw std::system_error(errno, std::generic_category(), "cannot make an event");
  }
  ~EventDescriptor() { ::close(descriptor_); }
  EventDescriptor(const EventDescriptor&) = delete;
  EventDescriptor& operator=(const EventDescriptor&) = delete;

  /// Makes it readable. This fails only where it is readable already.
  void signal() const noexcept { ::eventfd_write(descriptor_, 1); }
  /// Makes it unreadable until the next signal().
  void clear() const noexcept {
    eventfd_t signals = 0;
    ::eventfd_read(descriptor_, &signals);
  }
  /// The descriptor, for poll() only.
  int get() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace feltwire
