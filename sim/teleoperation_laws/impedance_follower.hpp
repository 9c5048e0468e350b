#pragma once

#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// The usual follower: the robot's impedance controller with the leader's newest position as its
/// target; it sends back the measured force and its state.
class ImpedanceFollower {
 public:
  explicit ImpedanceFollower(const Plant& plant) : plant_(plant) {}

  FollowerForce step(const FollowerSample& s, std::span<const Datagram> arrived, Datagram& out) {
    out.position = s.position;
    out.velocity = s.velocity;
    out.force = -s.force;
    newest_.take(arrived);
    if (!newest_.known()) return {0.0, plant_.controller_damping, 0.0};
    return {plant_.stiffness * (newest_->position - s.position), plant_.controller_damping,
            newest_->velocity};
  }

  const Newest& leader() const { return newest_; }

 private:
  Plant plant_;
  Newest newest_;
};

}  // namespace feltwire::teleop
