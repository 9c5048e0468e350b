#include "client/simulator/simulator_feed.hpp"

namespace feltwire {

bool SimulatorFeed::put(const SimulatorContact& contact) noexcept {
  if (!contacts_.push(contact)) return false;
  signal();
  return true;
}

bool SimulatorFeed::take(SimulatorContact& contact) noexcept {
  signal_.clear();
  bool any = false;
  while (contacts_.pop(contact)) any = true;
  return any;
}

}  // namespace feltwire
