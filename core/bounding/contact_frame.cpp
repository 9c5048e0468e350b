#include "core/bounding/contact_frame.hpp"

namespace feltwire {

template <class Real>
BasicCommand<Real> ContactFrameBound<Real>::step(const BasicBoundingStep<Real>& s) noexcept {
  ChannelCommand<Real> command = in_channels(s.command);
  command.elastic = std::max(Real(0), command.elastic);  // a contact never pulls
  // Then there is no normal either: friction has the whole movement, under any damping.
  if (!(command.elastic > 0)) command.normal.setZero();

  BasicCommand<Real> rendered;
  if (translation_.euclidean()) {
    const Scales scale = bound_force(command, s.displacement, s.hold_time);
    rendered.elastic = (scale.elastic * command.elastic) * command.normal;
    rendered.frictional = scale.frictional * command.frictional;
  } else {
    // In these coordinates friction may well have a part along u, and more of it than the spring:
    // what is across the normal for the eye is not what the device damps apart.
    const Real spring_share = command.elastic > 0 ? command.spring / command.elastic : Real(0);
    const BasicCommand<Real> whole{translation_.force(command.elastic * command.normal),
                                   translation_.force(command.frictional), s.command.torque};
    command = in_channels(whole);
    command.spring *= spring_share;
    const Scales scale = bound_force(command, translation_.movement(s.displacement), s.hold_time);
    rendered.elastic = translation_.force_back((scale.elastic * command.elastic) * command.normal);
    rendered.frictional = translation_.force_back(scale.frictional * command.frictional);
  }

  if (torque_) {
    const bool plain = rotation_.euclidean();
    rendered.torque =
        s.command.torque *
        bound_torque(plain ? s.command.torque : rotation_.force(s.command.torque),
                     plain ? s.rotation : rotation_.movement(s.rotation), s.hold_time);
  }
  return rendered;
}

template <class Real>
typename ContactFrameBound<Real>::Scales ContactFrameBound<Real>::bound_force(
    const ChannelCommand<Real>& command, const Vector3<Real>& displacement,
    Real hold_time) noexcept {
  const Real c = force_law_.c;
  const HeldFrame<Real> f(held_, command.normal, displacement);

  // (C), channel by channel; f = -F turns the sum into a difference.
  Debt<Real>& debt = force_debt_;
  debt.add(force_excess_);
  Real allowed_elastic = std::abs(f.elastic - c * f.dx_elastic);
  if (spare_ > 0) allowed_elastic = hypotenuse(allowed_elastic, spare_);
  allowed_elastic = allowed_magnitude(
      allowed_elastic, [&] { return std::abs(f.dx_elastic); }, hold_time, force_law_, debt);
  Real allowed_friction = allowed_magnitude(
      length(f.frictional - c * f.dx_frictional), [&] { return length(f.dx_frictional); },
      hold_time, force_law_, debt);
  if (debt.force > 0) [[unlikely]] {
    // Friction first: the normal force is missed more.
    allowed_friction = debt.repay(allowed_friction);
    allowed_elastic = debt.repay(allowed_elastic);
  }
  allowed_force_ = hypotenuse(allowed_elastic, allowed_friction);

  const Real elastic = std::abs(command.elastic);
  const Real friction = length(command.frictional);
  Scales scale{reduction(allowed_elastic, elastic), reduction(allowed_friction, friction)};
  scale.frictional = std::min(scale.frictional, scale.elastic);
  // A pull along the normal is only a part of friction; alone it must not stay.
  if (projection_ == Projection::joint || command.elastic < 0) scale.elastic = scale.frictional;

  last_.stored = spare_ > 0 ? hypotenuse(held_.elastic, spare_) : held_.elastic;
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

/// 2 c E(n) = 2 c E(n-1) + c (F(n-1) + F(n)) dx, F the spring's part; never more than the port took
/// in (`allowed`) nor than is left beside the friction's storage; never less than S(F(n)).
template <class Real>
void ContactFrameBound<Real>::store() noexcept {
  const Real held = held_.elastic;
  const Real friction = length(held_.frictional);
  const Real spring_share = last_.rendered > 0 ? std::min(Real(1), held / last_.rendered) : Real(0);
  spring_ = spring_share * last_.rendered_spring;
  spare_ = 0;
  if (!(held > 0) || friction >= allowed_force_) return;  // no contact, nothing kept
  const Real work = last_.stored * last_.stored + (last_.spring + spring_) * last_.pressed;
  const Real most = std::min(last_.allowed, root_difference(allowed_force_, friction));
  const Real stored = std::min(std::sqrt(std::max(Real(0), work)), most);
  if (stored > held) spare_ = root_difference(stored, held);
}

template <class Real>
void ContactFrameBound<Real>::set_held(const BasicCommand<Real>& held) noexcept {
  if (translation_.euclidean())
    held_.set(held);
  else
    held_.set({translation_.force(held.elastic), translation_.force(held.frictional), held.torque});
  if (storage_ == Storage::elastic) store();
  force_excess_ = excess(held_.magnitude(), allowed_force_);
  if (torque_) {
    held_torque_ = rotation_.euclidean() ? held.torque : rotation_.force(held.torque);
    torque_excess_ = excess(length(held_torque_), allowed_torque_);
  }
}

template class ContactFrameBound<double>;
template class ContactFrameBound<float>;

}  // namespace feltwire
