#include "client/servo/event.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace feltwire {

Event::Event() : descriptor_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (descriptor_ < 0)
    throw std::system_error(errno, std::generic_category(), "cannot make an event");
}
Event::~Event() { ::close(descriptor_); }
void Event::set() noexcept {
  set_.store(true, std::memory_order_release);
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written =
      ::write(descriptor_, &one, sizeof one);  // fails only if the event is already set
}

}  // namespace feltwire
