#pragma once

#include <algorithm>
#include <cmath>

#include "sim/teleoperation_laws/impedance_follower.hpp"
#include "sim/teleoperation_laws/port_tank.hpp"

namespace feltwire::teleop {

/// The two-layer approach: any controller above, P-F here; below it a tank at each end. A tank is
/// filled by the energy that its port takes in, sends a share beta of its level each sample, and
/// pays for the energy that its port gives. While the leader's is below its level a damper makes
/// the hand fill it.
///   H(n) = H(n-1) + F(n-1) dx(n) + received - beta H,     |F| <= H / |v T|, 0 where H <= 0
///   F = F_e(t-d) + alpha (H_d - H) v while H < H_d
/// Source: Franken, Stramigioli, Misra, Secchi, Macchelli, "Bilateral telemanipulation with time
/// delays: a two-layer approach combining passivity and transparency", IEEE Trans. Robotics 27(4),
/// 2011. Decided here: H_d = 0.3 J, which is also the first charge; beta = 1 %; alpha = 50; what is
/// sent travels as a total, so that a loss loses nothing. 0.3 J is little for the bench
/// (docs/lab/teleoperation.md, "The level of a tank").
class TwoLayer final : public TeleoperationLaw {
 public:
  /// `level` [J]: H_d of both tanks.
  explicit TwoLayer(const Plant& plant, double level = PortTank::kLevel)
      : plant_(plant), wanted_level_(level), leader_tank_{level}, robot_tank_{level} {}

  double lead(const LeaderSample& s, std::span<const Datagram> arrived, Datagram& out) override {
    constexpr double kDamper = 50.0;  // [N s/m] for each joule
    follower_.take(arrived);
    const double way = begun_ ? s.position - before_ : 0.0;
    before_ = s.position;
    begun_ = true;
    leader_tank_.exchange(held_ * way, arrived);
    double force =
        paid(leader_tank_, follower_.known() ? follower_->force : 0.0, s.velocity * plant_.period);
    force += kDamper * std::max(0.0, wanted_level_ - leader_tank_.level) * s.velocity;
    held_ = force;
    out.position = s.position;
    out.velocity = s.velocity;
    out.energy = leader_tank_.sent;
    return force;
  }

  FollowerForce follow(const FollowerSample& s, std::span<const Datagram> arrived,
                       Datagram& out) override {
    leader_.take(arrived);
    const double way = started_ ? s.position - robot_before_ : 0.0;
    robot_before_ = s.position;
    started_ = true;
    robot_tank_.exchange(-drive_ * way, arrived);
    double force = 0.0;
    if (leader_.known())
      force = plant_.stiffness * (leader_->position - s.position) +
              plant_.controller_damping * (leader_->velocity - s.velocity);
    drive_ = paid(robot_tank_, force, s.velocity * plant_.period);
    out.force = -s.force;
    out.energy = robot_tank_.sent;
    return {drive_, 0.0, 0.0};
  }

 private:
  static double paid(const PortTank& tank, double force, double way) {
    const double most = tank.most(std::abs(way));
    return std::clamp(force, -most, most);
  }

  Plant plant_;
  double wanted_level_;  // H_d [J]
  Newest leader_, follower_;
  PortTank leader_tank_, robot_tank_;
  double before_ = 0.0, held_ = 0.0, robot_before_ = 0.0, drive_ = 0.0;
  bool begun_ = false, started_ = false;
};

}  // namespace feltwire::teleop
