#pragma once

#include "sim/teleoperation_laws/spatial_law.hpp"

namespace feltwire::teleop {

/// ImpedanceFollower in three degrees of freedom.
class SpatialImpedance {
 public:
  explicit SpatialImpedance(const Plant& plant) : plant_(plant) {}

  SpatialFollowerForce step(const SpatialFollowerSample& s,
                            std::span<const SpatialDatagram> arrived, SpatialDatagram& out) {
    out.position = s.position;
    out.velocity = s.velocity;
    out.force = -s.force;
    newest_.take(arrived);
    if (!newest_.known()) return {.damping = plant_.controller_damping};
    return {plant_.stiffness * (newest_->position - s.position), plant_.controller_damping,
            newest_->velocity};
  }

 private:
  Plant plant_;
  NewestOf<SpatialDatagram> newest_;
};

}  // namespace feltwire::teleop
