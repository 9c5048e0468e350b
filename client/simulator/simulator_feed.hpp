#pragma once

#include "client/simulator/simulator_contact.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// The way of contacts from the thread of a simulator to the servo thread. Neither waits for the
/// other.
class SimulatorFeed {
 public:
  static constexpr std::size_t kRoom = 16;  // [contacts]

  /// Throws std::system_error if the system has no more descriptors.
  SimulatorFeed();
  ~SimulatorFeed();
  SimulatorFeed(const SimulatorFeed&) = delete;
  SimulatorFeed& operator=(const SimulatorFeed&) = delete;

  /// The simulator's thread. False: the servo has not taken the contacts before this one.
  bool put(const SimulatorContact& contact) noexcept;
  /// The servo thread. Returns the newest contact, and forgets the older ones. False: there is none
  /// since the last call.
  bool take(SimulatorContact& contact) noexcept;
  /// Makes the descriptor readable.
  void signal() const noexcept;
  /// Readable if take() has something, or signal() was called since.
  int descriptor() const noexcept { return descriptor_; }

 private:
  Ring<SimulatorContact> contacts_{kRoom};
  int descriptor_ = -1;
};

}  // namespace feltwire
