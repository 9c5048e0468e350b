#pragma once

#include <algorithm>
#include <limits>

#include "core/bounding/frame.hpp"
#include "core/bounding/law.hpp"
#include "core/bounding/midpoint.hpp"
#include "core/bounding/multi_contact_frame.hpp"
#include "core/bounding/oscillation_counter.hpp"

namespace feltwire {

/// The damping that `credited` assumes. For translation; for rotation read rad, N m.
struct CreditedLaw {
  double damping = 0.0;  // b [N s/m] lower bound of the device's damping
  double credit = 0.0;   // a [N s/m] at the beginning, assumed of the hand
  /// k [N/m] of the stiffest surface: no force need rise or fall faster.
  double stiffness = std::numeric_limits<double>::infinity();
};

/// The movement of the place half a sample ahead, if the motion continues at its speed.
template <class Real>
class HalfSampleLead {
 public:
  /// T [s]
  explicit HalfSampleLead(double period) : period_(static_cast<Real>(period)) {}

  /// `way` [m] [rad] is the movement of the last sample, over `time` [s]. Returns the movement of
  /// the place half a sample ahead since the call before, less `way`.
  Vector3<Real> more(const Vector3<Real>& way, Real time) noexcept {
    const bool another = time > Real(0) && time != period_;
    const Vector3<Real> speed = another ? Vector3<Real>((period_ / time) * way) : way;
    Vector3<Real> more = Real(0.5) * (speed - speed_);
    speed_ = speed;
    return more;
  }

 private:
  Real period_;
  Vector3<Real> speed_ = Vector3<Real>::Zero();  // [m] [rad] a period
};

/// mode `credited`: the channels of contact_frame, with the assumed damping of a hand beside that
/// of the device. With c' = 2 (b + a) / T, or k of the stiffest surface if that is
/// between 2 b / T and c', channel by channel,
///   |F(n)| <= |F(n-1) + c dx_ch(n) + (c' - c) dp_ch(n)|,   c = 2 b / T
///   dp(n) = p(n) - p(n-1),   p(n) = x(n) + (T/2) v(n)
/// p is the place of the hand half a sample later. The limit is a spring of c' that is made at the
/// device, and the force of a spring that is held for T is late by T/2 (midpoint.hpp has the same
/// for a surface). Asked at x(n) it takes c' T/2 = b + a of damping. The device has b, but a hand
/// may have less than a. So the credited part is asked half a sample ahead. Without credit this is
/// contact_frame without its storage, and passive. A force rises and falls by c' or more for every
/// metre. It keeps no storage and repays no debt, unlike contact_frame. A hand that swings
/// (oscillation_counter.hpp) has less damping than a: then a is halved, and grows again by kGrowth.
///
/// This is shaping, not a bound: with a hand without damping it generates energy. The account
/// behind it makes the port passive for every hand (core/bounding/account.hpp). It is for commands
/// that come late, over a network.
/// Known weakness: the force of a wall stiffer than c' rises as slowly as that of a wall of c', and
/// the force of a surface softer than c' falls as fast.
template <class Real>
class Credited {
 public:
  static constexpr double kGrowth = 0.05;       // [1/s] of a
  static constexpr double kLeastSwing = 50e-6;  // [m] a finger feels 10 um RMS
  static constexpr double kQuanta = 4.0;        // quanta of the encoder, the least size of a swing

  /// `period` is T [s], `quantum` [m] that of the encoder, `lag` [s] that of the motor.
  Credited(const CreditedLaw& translation, const CreditedLaw& rotation, double period,
           double quantum, bool torque, double lag = 0.0)
      : translation_(translation),
        rotation_(rotation),
        period_(period),
        reckoned_(period + 2.0 * lag),
        full_credit_(translation.credit),
        swings_(std::max(kLeastSwing, kQuanta * quantum)),
        translated_(period),
        rotated_(period),
        torque_(torque) {
    set_limits();
  }

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    const Polar<Real> elastic = polar(s.command.elastic);
    adapt(s, elastic.direction);
    const Vector3<Real> way =
        s.displacement + limit_.credited * translated_.more(s.displacement, s.hold_time);
    const Vector3<Real> turn =
        s.rotation + rotation_limit_.credited * rotated_.more(s.rotation, s.hold_time);
    const bool corner = s.normals != nullptr && s.normals->count > 1;
    BasicCommand<Real> rendered = corner ? at_walls(s, way) : at_contact(s, elastic, way);
    if (torque_) {
      const Vector3<Real> allowed = held_torque_ - rotation_limit_.stiffness * turn;
      rendered.torque = s.command.torque * reduction(allowed, s.command.torque);
      held_torque_ = rendered.torque;
    }
    return rendered;
  }

  void set_held(const BasicCommand<Real>& held) noexcept {
    held_.set(held, plain_);
    if (torque_) held_torque_ = held.torque;
  }

  /// The hand moved while another law was in force.
  void moved(const BasicBoundingStep<Real>& s) noexcept {
    translated_.more(s.displacement, s.hold_time);
    rotated_.more(s.rotation, s.hold_time);
  }

  void scene_changed() noexcept {
    translation_.stiffness = std::numeric_limits<double>::infinity();
    set_limits();
  }
  HandCredit hand_credit() const noexcept {
    return {.damping = translation_.credit, .steps_down = steps_down_};
  }

 private:
  struct Limit {
    Real stiffness = 0;  // c' [N/m] [N m/rad]
    Real credited = 0;   // (c' - c) / c'
  };
  Limit limit_of(const CreditedLaw& law) const noexcept {
    const double least = 2.0 * law.damping / reckoned_;
    const double most = least + 2.0 * law.credit / reckoned_;
    const Real c = static_cast<Real>(std::min(most, std::max(least, law.stiffness)));
    return {c, c > Real(0) ? Real(1) - static_cast<Real>(least) / c : Real(0)};
  }
  void set_limits() noexcept {
    limit_ = limit_of(translation_);
    rotation_limit_ = limit_of(rotation_);
  }

  BasicCommand<Real> at_contact(const BasicBoundingStep<Real>& s, const Polar<Real>& wanted,
                                const Vector3<Real>& way) noexcept {
    const ChannelCommand<Real> command = in_channels(s.command, wanted, plain_);
    const HeldFrame<Real> f(held_, command.normal, way);
    const Real c = limit_.stiffness;
    const Real elastic = std::abs(f.elastic - c * f.dx_elastic);
    const Vector3<Real> friction = f.frictional - c * f.dx_frictional;
    ChannelScales<Real> scale{reduction(elastic, std::abs(command.elastic)),
                              reduction(friction, command.frictional)};
    scale.frictional = std::min(scale.frictional, scale.elastic);
    held_.set(command.normal, scale.elastic * command.elastic,
              scale.frictional * command.frictional);
    return held_back(command, scale, plain_);
  }

  /// A channel for each wall. The walls of this command split the held force, so no channel has a
  /// memory.
  BasicCommand<Real> at_walls(const BasicBoundingStep<Real>& s, const Vector3<Real>& way) noexcept {
    const MultiContactFrame<Real> walls(*s.normals);
    const Vector3<Real> held = held_.elastic * held_.normal + held_.frictional;
    const Vector3<Real> wanted = s.command.force();
    const Real c = limit_.stiffness;
    BasicCommand<Real> rendered;
    Vector3<Real> elastic = Vector3<Real>::Zero();  // the wanted one
    for (int i = 0; i < walls.count(); ++i) {
      const Vector3<Real> normal = walls.normal(i);
      const Real before = std::max(Real(0), walls.part(i, held));
      const Real force = std::max(Real(0), walls.part(i, wanted));
      const Real allowed = std::abs(before - c * walls.weight(i) * normal.dot(way));
      elastic += force * normal;
      rendered.elastic += std::min(force, allowed) * normal;
    }
    const Vector3<Real> friction = walls.across(wanted);
    const Real allowed = length(walls.across(held) - c * walls.across(way));
    const Real share = reduction(length(rendered.elastic), length(elastic));
    rendered.frictional = std::min(share, reduction(allowed, length(friction))) * friction;
    held_.set(rendered, plain_);
    return rendered;
  }

  void adapt(const BasicBoundingStep<Real>& s, const Vector3<Real>& normal) noexcept {
    const double time = static_cast<double>(s.hold_time);
    if (normal.isZero(0)) {
      swings_.forget();
    } else if (swings_.moved(static_cast<double>(s.displacement.dot(normal)), time)) {
      constexpr double kHalf = 0.5;
      translation_.credit *= kHalf;
      rotation_.credit *= kHalf;
      ++steps_down_;
    }
    if (!(translation_.credit < full_credit_)) return;
    const double growth = std::min(full_credit_ / translation_.credit, std::exp(kGrowth * time));
    translation_.credit *= growth;
    rotation_.credit *= growth;
    set_limits();
  }

  CreditedLaw translation_, rotation_;
  double period_, reckoned_, full_credit_;  // reckoned_: BoundingConfig::reckoned_period()
  Limit limit_, rotation_limit_;            // they follow from the laws
  OscillationCounter swings_;
  HalfSampleLead<Real> translated_, rotated_;
  bool torque_;
  std::uint64_t steps_down_ = 0;
  Metric<Real> plain_{Damping(1.0)};
  HeldForce<Real> held_;
  Vector3<Real> held_torque_ = Vector3<Real>::Zero();  // [N m]
};

/// mode `shaped` chooses for each command. A command that was made at the device, half a sample
/// ahead (BasicBoundingStep::local), goes through Midpoint, which renders it unchanged as long as
/// the hand is calm. A late command goes through Credited.
template <class Real>
class Shaped {
 public:
  /// `quantum` [m] of the encoder; `period` T [s]; `lag` [s] of the motor.
  Shaped(const Credited<Real>& late, double quantum, double period, double lag = 0.0)
      : late_(late), near_(quantum, period, lag) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    if (s.local) {
      was_near_ = true;
      late_.moved(s);
      return held_ = near_.step(s);
    }
    near_.moved(s);
    if (was_near_) late_.set_held(held_);
    was_near_ = false;
    return late_.step(s);
  }
  void set_held(const BasicCommand<Real>& held) noexcept {
    was_near_ ? void(held_ = held) : late_.set_held(held);
  }
  /// Like Midpoint::probe(), for commands that are made at the device.
  BasicProbe<Real> probe(const Vector3<Real>& displacement,
                         const Vector3<Real>& rotation) const noexcept {
    return near_.probe(displacement, rotation);
  }
  void scene_changed() noexcept { late_.scene_changed(); }
  HandCredit hand_credit() const noexcept {
    const HandCredit late = late_.hand_credit(), near = near_.hand_credit();
    return {late.damping, late.steps_down, near.near_share, near.near_steps_down, near.untold_lag};
  }

 private:
  Credited<Real> late_;
  Midpoint<Real> near_;
  // Split into channels for `late_` only when a command comes late again, not at every step.
  BasicCommand<Real> held_;
  bool was_near_ = false;
};

}  // namespace feltwire
