#pragma once
// The definitions of ContactFrameBound, for arithmetics other than double.

#include <algorithm>
#include <cmath>

#include "core/bounding/contact_frame.hpp"

namespace feltwire {

template <class Real>
BasicCommand<Real> ContactFrameBound<Real>::step(const BasicBoundingStep<Real>& s) noexcept {
  const ChannelCommand<Real> command = in_channels(s.command, translation_);
  const ChannelScales<Real> scale =
      bound_force(command, translation_.movement(s.displacement), s.hold_time);
  BasicCommand<Real> rendered = held_back(command, scale, translation_);
  if (torque_)
    rendered.torque = s.command.torque * bound_torque(rotation_.force(s.command.torque),
                                                      rotation_.movement(s.rotation), s.hold_time);
  return rendered;
}

template <class Real>
ChannelScales<Real> ContactFrameBound<Real>::bound_force(const ChannelCommand<Real>& command,
                                                         const Vector3<Real>& displacement,
                                                         Real hold_time) noexcept {
  const Real c = force_law_.c;
  const HeldFrame<Real> f(held_, command.normal, displacement);

  // (C), channel by channel; f = -F turns the sum into a difference.
  Debt<Real>& debt = force_debt_;
  debt.add(force_excess_);
  Real allowed_elastic = std::abs(f.elastic - c * f.dx_elastic);
  if (spare_ > 0) allowed_elastic = hypotenuse(allowed_elastic, spare_);
  if (endowed_ > 0) [[unlikely]]
    allowed_elastic = hypotenuse(allowed_elastic, endowed_);
  allowed_elastic = allowed_magnitude(
      allowed_elastic, [&] { return std::abs(f.dx_elastic); }, hold_time, force_law_, debt);
  Real allowed_friction = allowed_magnitude(
      length(f.frictional - c * f.dx_frictional), [&] { return length(f.dx_frictional); },
      hold_time, force_law_, debt);
  if (debt.force > 0) [[unlikely]] {
    // Friction repays first, because a missing normal force is noticed more.
    allowed_friction = debt.repay(allowed_friction);
    allowed_elastic = debt.repay(allowed_elastic);
  }
  allowed_force_ = hypotenuse(allowed_elastic, allowed_friction);

  const Real elastic = std::abs(command.elastic);
  const Real friction = length(command.frictional);
  ChannelScales<Real> scale{reduction(allowed_elastic, elastic),
                            reduction(allowed_friction, friction)};
  scale.frictional = std::min(scale.frictional, scale.elastic);
  // A pull along the normal is only a part of friction; alone it must not remain.
  if (projection_ == Projection::joint || command.elastic < 0) scale.elastic = scale.frictional;

  last_.stored = spare_ > 0 ? hypotenuse(held_.elastic, spare_) : held_.elastic;
  if (endowed_ > 0) [[unlikely]]
    last_.stored = hypotenuse(last_.stored, endowed_);
  endowed_ = 0;
  last_.spring = spring_;
  last_.pressed = -c * f.dx_elastic;
  last_.allowed = allowed_elastic;
  last_.rendered = scale.elastic * elastic;
  last_.rendered_spring = command.elastic < 0 ? Real(0) : scale.elastic * command.spring;
  held_.set(command.normal, scale.elastic * command.elastic, scale.frictional * command.frictional);
  force_excess_ = 0;
  if (storage_ == Storage::elastic) store();
  return scale;
}

template <class Real>
Real ContactFrameBound<Real>::bound_torque(const Vector3<Real>& command,
                                           const Vector3<Real>& rotation, Real hold_time) noexcept {
  torque_debt_.add(torque_excess_);
  allowed_torque_ = allowed_magnitude(
      length(held_torque_ - torque_law_.c * rotation), [&] { return length(rotation); }, hold_time,
      torque_law_, torque_debt_);
  if (torque_debt_.force > 0) [[unlikely]]
    allowed_torque_ = torque_debt_.repay(allowed_torque_);
  const Real scale = reduction(allowed_torque_, length(command));
  held_torque_ = scale * command;
  torque_excess_ = 0;
  return scale;
}

/// 2 c E(n) = 2 c E(n-1) + c (F(n-1) + F(n)) dx, F the spring's part. It is at most the energy that
/// the port took in (`allowed`), less the friction's storage, and at least S(F(n)).
template <class Real>
void ContactFrameBound<Real>::store() noexcept {
  const Real held = held_.elastic;
  const Real friction = length(held_.frictional);
  const Real spring_share = last_.rendered > 0 ? std::min(Real(1), held / last_.rendered) : Real(0);
  spring_ = spring_share * last_.rendered_spring;
  spare_ = 0;
  if (!(held > 0) || friction >= allowed_force_) return;  // no contact, nothing is kept
  const Real work = last_.stored * last_.stored + (last_.spring + spring_) * last_.pressed;
  const Real most = std::min(last_.allowed, root_difference(allowed_force_, friction));
  const Real stored = std::min(std::sqrt(std::max(Real(0), work)), most);
  if (stored > held) spare_ = root_difference(stored, held);
}

template <class Real>
void ContactFrameBound<Real>::set_held(const BasicCommand<Real>& held) noexcept {
  held_.set(held, translation_);
  if (storage_ == Storage::elastic) store();
  force_excess_ = excess(held_.magnitude(), allowed_force_);
  if (torque_) {
    held_torque_ = rotation_.force(held.torque);
    torque_excess_ = excess(length(held_torque_), allowed_torque_);
  }
}

}  // namespace feltwire
