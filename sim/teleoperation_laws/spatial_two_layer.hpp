#pragma once

#include <algorithm>
#include <optional>

#include "core/base/clamp_length.hpp"
#include "core/base/numeric.hpp"
#include "sim/teleoperation_laws/port_tank.hpp"
#include "sim/teleoperation_laws/spatial_law.hpp"

namespace feltwire::teleop {

/// TwoLayer in three degrees of freedom. Decided here: one tank at each end for all coordinates, as
/// energies add up; the force is shortened as a whole, so it keeps its direction; the damper that
/// fills the tank works against the velocity.
class SpatialTwoLayer final : public SpatialLaw {
 public:
  explicit SpatialTwoLayer(const Plant& plant) : plant_(plant) {}

  Vec3 lead(const SpatialLeaderSample& s, std::span<const SpatialDatagram> arrived,
            SpatialDatagram& out) override {
    constexpr double kDamper = 50.0;  // [N s/m] for each joule
    follower_.take(arrived);
    leader_tank_.exchange(held_.dot(moved(hand_before_, s.position)), arrived);
    Vec3 force = Vec3::Zero();
    if (follower_.known()) force = paid(leader_tank_, follower_->force, s.velocity);
    force += kDamper * std::max(0.0, PortTank::kLevel - leader_tank_.level) * s.velocity;
    held_ = force;
    out.position = s.position;
    out.velocity = s.velocity;
    out.energy = leader_tank_.sent;
    return force;
  }

  SpatialFollowerForce follow(const SpatialFollowerSample& s,
                              std::span<const SpatialDatagram> arrived,
                              SpatialDatagram& out) override {
    leader_.take(arrived);
    robot_tank_.exchange(-drive_.dot(moved(robot_before_, s.position)), arrived);
    Vec3 force = Vec3::Zero();
    if (leader_.known())
      force = plant_.stiffness * (leader_->position - s.position) +
              plant_.controller_damping * (leader_->velocity - s.velocity);
    drive_ = paid(robot_tank_, force, s.velocity);
    out.force = -s.force;
    out.energy = robot_tank_.sent;
    return {.force = drive_};
  }

 private:
  Vec3 paid(const PortTank& tank, const Vec3& force, const Vec3& velocity) const {
    return clamp_length(force, tank.most(length(velocity) * plant_.period));
  }

  Plant plant_;
  NewestOf<SpatialDatagram> leader_, follower_;
  PortTank leader_tank_, robot_tank_;
  std::optional<Vec3> hand_before_, robot_before_;   // [m]
  Vec3 held_ = Vec3::Zero(), drive_ = Vec3::Zero();  // [N]
};

}  // namespace feltwire::teleop
