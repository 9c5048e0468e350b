#pragma once

#include "sim/teleoperation_laws/spatial_law.hpp"
#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// The usual follower: the robot's impedance controller with the leader's newest position as its
/// target; it sends back the measured force and its state.
template <class Sample, class Force, class Message>
class ImpedanceController {
 public:
  explicit ImpedanceController(const Plant& plant) : plant_(plant) {}

  Force step(const Sample& s, std::span<const Message> arrived, Message& out) {
    out.position = s.position;
    out.velocity = s.velocity;
    out.force = -s.force;
    newest_.take(arrived);
    if (!newest_.known()) return {.damping = plant_.controller_damping};
    return {plant_.stiffness * (newest_->position - s.position), plant_.controller_damping,
            newest_->velocity};
  }
  const NewestOf<Message>& leader() const { return newest_; }

 private:
  Plant plant_;
  NewestOf<Message> newest_;
};

/// In one degree of freedom, and in three.
using ImpedanceFollower = ImpedanceController<FollowerSample, FollowerForce, Datagram>;
using SpatialImpedance =
    ImpedanceController<SpatialFollowerSample, SpatialFollowerForce, SpatialDatagram>;

}  // namespace feltwire::teleop
