#pragma once
// The definitions of BasicBounding, for arithmetics other than double.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/bounding/bounding.hpp"
#include "core/bounding/frame.hpp"

namespace feltwire {
namespace bounding_detail {

/// Checks a configuration by the rules of every method. Throws std::invalid_argument.
void check(const BoundingConfig& config, std::string_view method, bool needs_every_axis_damped);

/// False for NaN too, because every comparison with NaN is false.
template <class Real>
bool sane(const Vector3<Real>& v, double limit) {
  return std::abs(v.x()) <= limit && std::abs(v.y()) <= limit && std::abs(v.z()) <= limit;
}
template <class Real>
bool sane(const BasicCommand<Real>& c) {
  return sane(c.elastic, kLargestForce) && sane(c.frictional, kLargestForce) &&
         sane(c.torque, kLargestForce);
}
template <class Real>
bool sane(const BasicBoundingStep<Real>& s) {
  return sane(s.command) && sane(s.displacement, kLargestMovement) &&
         sane(s.rotation, kLargestMovement) && std::abs(s.hold_time) <= kLargestHold;
}

/// Larger than rounding. For vectors within the limits no square overflows.
template <class Real>
bool differs(const Vector3<Real>& a, const Vector3<Real>& b) {
  constexpr Real kRounding = 256 * std::numeric_limits<Real>::epsilon();
  return (a - b).squaredNorm() > kRounding * kRounding * b.squaredNorm();
}

/// Compares squares first, which is enough if nothing is to be reduced. Returns the factor.
template <class Real>
Real limit_factor(const Vector3<Real>& v, Real limit) {
  return v.squaredNorm() <= limit * limit ? Real(1) : reduction(limit, length(v));
}

}  // namespace bounding_detail

template <class Real>
BasicBounding<Real>::BasicBounding(const BasicBoundingMethod<Real>& method,
                                   const BoundingConfig& config)
    : config_(
          (bounding_detail::check(config, method.name, method.needs_every_axis_damped), config)),
      period_(static_cast<Real>(config.period)),
      max_force_(static_cast<Real>(config.max_force)),
      max_torque_(static_cast<Real>(config.max_torque)),
      rotation_(config.rotation),
      translation_damping_(config.damping),
      rotational_damping_(config.rotational_damping),
      law_(method.make(config)) {
  config_.mode = method.name;
}

/// The step with usable values only: each unusable value is replaced by the worst possible one.
template <class Real>
BasicBoundingStep<Real> BasicBounding<Real>::checked(const Step& given,
                                                     bool& refused) const noexcept {
  using bounding_detail::sane;
  Step s = given;
  if (!rotation_) s.command.torque = s.rotation = Vector3<Real>::Zero();
  refused = !sane(s);
  const bool hold_sane = std::abs(s.hold_time) <= kLargestHold;
  // A hold shorter than T earns no more credit than T.
  if (!hold_sane || s.hold_time < period_) s.hold_time = period_;
  if (!refused) [[likely]]
    return s;
  s.command = {};
  if (!sane(s.displacement, kLargestMovement))
    s.displacement = translation_damping_.worst_movement(held_.force(), s.hold_time);
  if (!sane(s.rotation, kLargestMovement))
    s.rotation = rotational_damping_.worst_movement(held_.torque, s.hold_time);
  // The duration of the movement is not known, so it earns no credit.
  if (!hold_sane) s.hold_time = static_cast<Real>(kLargestHold);
  return s;
}

template <class Real>
bool BasicBounding<Real>::saturate(BasicCommand<Real>& rendered) const noexcept {
  using bounding_detail::limit_factor;
  const Real force_factor = limit_factor<Real>(rendered.force(), max_force_);
  const Real torque_factor = rotation_ ? limit_factor(rendered.torque, max_torque_) : Real(1);
  if (force_factor == 1 && torque_factor == 1) return false;
  rendered.elastic *= force_factor;
  rendered.frictional *= force_factor;
  rendered.torque *= torque_factor;
  return true;
}

template <class Real>
BasicBounded<Real> BasicBounding<Real>::step(const Step& given) noexcept {
  // The usual step is not copied.
  if (rotation_ && given.hold_time >= period_ && bounding_detail::sane(given))
    return bounded(given, false);
  bool refused = false;
  const Step replaced = checked(given, refused);
  return bounded(replaced, refused);
}

template <class Real>
BasicBounded<Real> BasicBounding<Real>::bounded(const Step& s, bool refused) noexcept {
  using namespace bounding_detail;
  BasicBounded<Real> result;
  result.refused = refused;
  const BasicLawAnswer<Real> answer = law_.step(s);
  result.rendered = answer.rendered;
  result.in_debt = answer.in_debt;
  // The paper's laws would keep a part of the last force. Zero is passive, too: the stored energy
  // pays for the worst movement of the hand.
  if (result.refused) [[unlikely]]
    result.rendered = {};
  result.active = differs<Real>(result.rendered.force(), s.command.force()) ||
                  (rotation_ && differs(result.rendered.torque, s.command.torque));
  result.saturated = saturate(result.rendered);
  held_ = result.rendered;
  if (result.refused || result.saturated) law_.set_held(held_);
  return result;
}

template <class Real>
void BasicBounding<Real>::set_held(const BasicCommand<Real>& held) noexcept {
  if (held == held_ || !bounding_detail::sane(held)) return;
  held_ = held;
  law_.set_held(held);
}

template <class Real>
void BasicBounding<Real>::endow(Real energy) noexcept {
  if (energy > 0 && std::isfinite(energy)) law_.endow(energy);
}

template <class Real>
BasicProbe<Real> BasicBounding<Real>::probe(const Vector3<Real>& displacement,
                                            const Vector3<Real>& rotation) const noexcept {
  return law_.probe(displacement, rotation);
}

}  // namespace feltwire
