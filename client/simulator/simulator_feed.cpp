#include "client/simulator/simulator_feed.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace feltwire {

SimulatorFeed::SimulatorFeed() : descriptor_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

SimulatorFeed::~SimulatorFeed() { ::close(descriptor_); }

bool SimulatorFeed::put(const SimulatorContact& contact) noexcept {
  if (!contacts_.push(contact)) return false;
  signal();
  return true;
}

bool SimulatorFeed::take(SimulatorContact& contact) noexcept {
  std::uint64_t signals = 0;
  // It has nothing to read where nobody signalled.
  [[maybe_unused]] const ssize_t read = ::read(descriptor_, &signals, sizeof signals);
  bool any = false;
  while (contacts_.pop(contact)) any = true;
  return any;
}

void SimulatorFeed::signal() const noexcept {
  const std::uint64_t one = 1;
  // It fails only if 2^64 signals wait.
  [[maybe_unused]] const ssize_t written = ::write(descriptor_, &one, sizeof one);
}

}  // namespace feltwire
