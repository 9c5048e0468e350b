#pragma once

#include <algorithm>
#include <cmath>

#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// Two-port time-domain passivity control with drift compensation. The energy of each port is split
/// by its sign; each end lets out at most the energy that the other end has reported as taken in:
///   follower   W_f = E_in^l(seen) - E_out^f + E_PC^f < 0:   v_sd = v_l - beta F_c,
///              beta = -W_f / (T F_c^2); where W_f > 0 the drift is made good, v_ad = (x_l -
///              x_sd)/T, as far as W_f pays for it
///   leader     W_l = E_in^f(seen) - E_out^l + E_PC^l < 0:   F = F_r + alpha v, alpha = -W_l / (T
///   v^2)
/// Sources: Ryu, Artigas, Preusche, "A passive bilateral control scheme for a teleoperator with
/// time-varying communication delay", Mechatronics 20(7), 2010; Chawda, Ha, O'Malley, Ryu, "Drift
/// compensation for time domain passivity approach", World Haptics, 2013.
/// Decided here: if W_l < 0 no force that pushes the hand is allowed; alpha is at most m / (2 T) of
/// the device's handle, because a larger one chatters; the coupling that makes F_c is the robot's
/// own controller; velocities within 1 um a sample count as zero.
class DelayedPassivity final : public TeleoperationLaw {
 public:
  explicit DelayedPassivity(const Plant& plant)
      : plant_(plant), most_(0.5 * plant.leader_mass / plant.period) {}

  double lead(const LeaderSample& s, std::span<const Datagram> arrived, Datagram& out) override {
    for (const Datagram& d : arrived) seen_follower_ = std::max(seen_follower_, d.energy);
    follower_.take(arrived);
    const double received = follower_.known() ? follower_->force : 0.0;
    const double way = begun_ ? s.position - before_ : 0.0;
    before_ = s.position;
    begun_ = true;
    const double work = held_ * way;  // of the force that was held, the controller's part included
    energy_in_ += std::max(0.0, work);
    energy_out_ += std::max(0.0, -work);
    const double left = seen_follower_ - energy_out_;
    double force = received;
    constexpr double kStill = 1e-3;  // [m/s]
    if (left < 0.0 && received * s.velocity < 0.0) force = 0.0;
    if (left < 0.0 && std::abs(s.velocity) > kStill) {
      const double alpha = -left / (plant_.period * s.velocity * s.velocity);
      force += std::min(alpha, most_) * s.velocity;
    }
    held_ = force;
    out.position = s.position;
    out.velocity = s.velocity;
    out.energy = energy_in_;
    return force;
  }

  FollowerForce follow(const FollowerSample& s, std::span<const Datagram> arrived,
                       Datagram& out) override {
    for (const Datagram& d : arrived) seen_leader_ = std::max(seen_leader_, d.energy);
    leader_.take(arrived);
    if (!started_) desired_ = s.position;
    started_ = true;
    const double wanted = leader_.known() ? leader_->velocity : 0.0;
    const double coupling = plant_.stiffness * (desired_ - s.position) +
                            plant_.controller_damping * (last_speed_ - s.velocity);
    double speed = wanted;
    const double left = seen_leader_ - spent_ - std::max(0.0, coupling * speed * plant_.period);
    constexpr double kNoForce = 1e-3;  // [N]
    if (left < 0.0 && std::abs(coupling) > kNoForce) {
      speed += left / (plant_.period * coupling);
      if (speed * wanted < 0.0) speed = 0.0;
    } else if (leader_.known()) {
      const double drift = leader_->position - (desired_ + speed * plant_.period);
      constexpr double kFastest = 0.1;  // [m/s] of the compensation
      double more = std::clamp(drift / plant_.period, -kFastest, kFastest);
      const double cost = coupling * more * plant_.period;
      if (cost > left) more *= left > 0.0 ? left / cost : 0.0;
      speed += more;
    }
    const double work = coupling * speed * plant_.period;
    spent_ += std::max(0.0, work);
    returned_ += std::max(0.0, -work);
    desired_ += speed * plant_.period;
    last_speed_ = speed;
    out.force = coupling;
    out.energy = returned_;
    return {plant_.stiffness * (desired_ - s.position), plant_.controller_damping, speed};
  }

 private:
  Plant plant_;
  double most_;  // [N s/m]
  Newest leader_, follower_;
  double seen_follower_ = 0.0, seen_leader_ = 0.0;  // [J]
  double energy_in_ = 0.0, energy_out_ = 0.0;       // [J] at the leader
  double before_ = 0.0, held_ = 0.0;                // [m], [N]
  double spent_ = 0.0, returned_ = 0.0;             // [J] at the follower
  double desired_ = 0.0, last_speed_ = 0.0;         // [m], [m/s]
  bool begun_ = false, started_ = false;
};

}  // namespace feltwire::teleop
