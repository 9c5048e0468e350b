#pragma once

#include "client/simulator/simulator_contact.hpp"
#include "core/base/event_descriptor.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// The way of contacts from the thread of a simulator to the servo thread. Neither waits for the
/// other. The constructor throws std::system_error if the system has no more descriptors.
class SimulatorFeed {
 public:
  static constexpr std::size_t kRoom = 16;  // [contacts]

  /// The simulator's thread. False: the servo has not taken the contacts before this one.
  bool put(const SimulatorContact& contact) noexcept;
  /// The servo thread. Returns the newest contact, and forgets the older ones. False: there is none
  /// since the last call.
  bool take(SimulatorContact& contact) noexcept;
  /// Makes the descriptor readable.
  void signal() const noexcept { signal_.signal(); }
  /// Readable if take() has something, or signal() was called since.
  int descriptor() const noexcept { return signal_.get(); }

 private:
  Ring<SimulatorContact> contacts_{kRoom};
  EventDescriptor signal_;
};

}  // namespace feltwire
