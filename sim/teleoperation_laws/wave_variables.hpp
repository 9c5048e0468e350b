#pragma once

#include <cmath>

#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// Wave variables, a line of impedance b between both ends:
///   leader     F_l = b v_l - sqrt(2b) w(t-d),    u = sqrt(2b) v_l - w(t-d)
///   follower   v_d = (sqrt(2b) u(t-d) + B v_f - K e) / (b + B),    F_f = K e + B (v_d - v_f)
///              w = u(t-d) - sqrt(2/b) F_f,       e = integral of v_d, less x_f
/// Displayed of a spring K_s: 1/K = 1/K_s + d/b; in free space an inertia b d.
/// Source: Niemeyer, Slotine, "Telemanipulation with time delays", Int. J. Robotics Research 23(9),
/// 2004. Matched: B = b. Decided here: on loss the last wave is held, and the position goes on by
/// the integral of the wave, which is sent beside it, so that a lost datagram alone is no drift.
class WaveVariables final : public TeleoperationLaw {
 public:
  WaveVariables(const Plant& plant, double impedance) : plant_(plant), b_(impedance) {}

  double lead(const LeaderSample& s, std::span<const Datagram> arrived, Datagram& out) override {
    follower_.take(arrived);
    const double w = follower_.known() ? follower_->wave : 0.0;
    const double root = std::sqrt(2.0 * b_);
    if (!begun_) start_ = s.position;
    begun_ = true;
    returned_ += w * plant_.period;
    out.wave = root * s.velocity - w;
    out.wave_integral = root * (s.position - start_) - returned_;
    return b_ * s.velocity - root * w;
  }

  FollowerForce follow(const FollowerSample& s, std::span<const Datagram> arrived,
                       Datagram& out) override {
    leader_.take(arrived);
    if (!started_) desired_ = s.position;
    started_ = true;
    const double u = leader_.known() ? leader_->wave : 0.0;
    // The part that the held waves did not transmit: the sent integral, less the used one.
    if (leader_.known()) desired_ += missing(leader_->wave_integral) / std::sqrt(2.0 * b_);
    const double e = desired_ - s.position;
    const double wanted =
        (std::sqrt(2.0 * b_) * u + b_ * s.velocity - plant_.stiffness * e) / (2.0 * b_);
    const double force = plant_.stiffness * e + b_ * (wanted - s.velocity);
    desired_ += wanted * plant_.period;
    used_ += u * plant_.period;
    out.wave = u - std::sqrt(2.0 / b_) * force;
    return {force, 0.0, 0.0};
  }

 private:
  /// [sqrt W s] A share of the missing part, once a sample; small, so that it makes no force.
  double missing(double sent) noexcept {
    constexpr double kShare = 2e-3;
    const double corrected = kShare * (sent - used_);
    used_ += corrected;
    return corrected;
  }

  Plant plant_;
  double b_;  // [N s/m]
  Newest leader_, follower_;
  bool begun_ = false, started_ = false;
  double start_ = 0.0, returned_ = 0.0;  // [m], [sqrt W s]
  double desired_ = 0.0, used_ = 0.0;    // [m], [sqrt W s]
};

}  // namespace feltwire::teleop
