#pragma once

#include <cmath>

#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// P-P: each end is drawn to the other's place by a spring and a damper.
///   F_l = K (x_l - x_f(t-d)) + B (v_l - v_f(t-d)),    F_f = K (x_l(t-d) - x_f) + B (v_l(t-d) -
///   v_f)
/// Source: Nuno, Basanez, Ortega, "Passivity-based control for bilateral teleoperation: a
/// tutorial", Automatica 47(3), 2011. Stable under delay where 4 B_l B_f > (d1 + d2)^2 K^2. Decided
/// here: K is the robot's own controller. The damper at the leader is B = 5 N s/m, as its device
/// has little damping of its own.
///
/// With `forces`, 4-channel: both ends also feed the other's force forward,
///   F_l' = (F_l + F_e(t-d)) / 2,    F_f' = F_f + F_l'(t-d) / 2
/// Source: Lawrence, IEEE Trans. Robotics and Automation 9(5), 1993. Decided here: halves, and the
/// force that the hand is given in place of a sensor of the hand's force.
class PositionPosition final : public TeleoperationLaw {
 public:
  PositionPosition(const Plant& plant, bool forces) : plant_(plant), forces_(forces) {}

  double lead(const LeaderSample& s, std::span<const Datagram> arrived, Datagram& out) override {
    constexpr double kDamping = 5.0, kHalf = 0.5;  // [N s/m]
    follower_.take(arrived);
    out.position = s.position;
    out.velocity = s.velocity;
    if (!follower_.known()) return 0.0;
    double force = plant_.stiffness * (s.position - follower_->position) +
                   kDamping * (s.velocity - follower_->velocity);
    if (forces_) force = kHalf * (force + follower_->force);
    out.force = force;
    return force;
  }
  FollowerForce follow(const FollowerSample& s, std::span<const Datagram> arrived,
                       Datagram& out) override {
    constexpr double kHalf = 0.5;
    leader_.take(arrived);
    out.position = s.position;
    out.velocity = s.velocity;
    out.force = -s.force;
    if (!leader_.known()) return {0.0, plant_.controller_damping, 0.0};
    const double spring = plant_.stiffness * (leader_->position - s.position);
    return {spring + (forces_ ? kHalf * leader_->force : 0.0), plant_.controller_damping,
            leader_->velocity};
  }

 private:
  Plant plant_;
  bool forces_;
  Newest leader_, follower_;
};

}  // namespace feltwire::teleop
