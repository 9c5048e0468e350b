#pragma once
// A bounding method of any number type as a session runs it, for the stress tests.

#include <cmath>
#include <limits>
#include <optional>

#include "core/bounding/account.hpp"
#include "core/bounding/device_account.hpp"
#include "sim/studies/bound/in_float.hpp"

namespace feltwire {

/// Converts a number to Real (double or float). A number beyond the range of Real becomes infinite.
template <class Real>
Real narrowed(double value) {
  if (std::abs(value) > std::numeric_limits<Real>::max())
    return std::copysign(std::numeric_limits<Real>::infinity(),
                         static_cast<Real>(value > 0 ? 1 : -1));
  return static_cast<Real>(value);
}
template <class Real>
Vector3<Real> narrowed(const Vec3& v) {
  return {narrowed<Real>(v.x()), narrowed<Real>(v.y()), narrowed<Real>(v.z())};
}
template <class Real>
BasicCommand<Real> narrowed(const Command& c) {
  return {narrowed<Real>(c.elastic), narrowed<Real>(c.frictional), narrowed<Real>(c.torque)};
}

/// The account of a device of unknown mass, that any hand may hold. It looks ahead, as a session's
/// does behind a method that shapes.
inline AccountConfig looking_ahead(const BoundingConfig& bound) {
  DeviceSpec device;
  device.damping = bound.damping;
  device.rotational_damping = bound.rotational_damping;
  device.rotation_actuated = 3;
  AccountConfig account = any_hand_account(device, bound.period);
  account.looks_ahead = true;
  return account;
}

/// A method as a session runs it: the bound, then the account if the method shapes. The account
/// computes in double, and its result is rounded to Real.
template <class Real>
class BoundInSession {
 public:
  BoundInSession(const BasicBoundingMethod<Real>& method, const BoundingConfig& config)
      : bounding_(method, config) {
    if (method.shapes) account_.emplace(looking_ahead(config));
  }

  BasicBounded<Real> step(const BasicBoundingStep<Real>& told) {
    BasicBounded<Real> out = bounding_.step(told);
    if (!account_) return out;
    BoundingStep paid{told.displacement.template cast<double>(),
                      told.rotation.template cast<double>(), static_cast<double>(told.hold_time),
                      out.rendered.template cast<double>()};
    // A session tells the account of an unknown movement when it refuses one.
    if (out.refused) paid.displacement.setConstant(std::numeric_limits<double>::quiet_NaN());
    out.rendered = narrowed<Real>(account_->step(paid));
    set_held(out.rendered);
    return out;
  }
  void set_held(const BasicCommand<Real>& held) {
    bounding_.set_held(held);
    if (account_) account_->set_held(held.template cast<double>());
  }
  BasicProbe<Real> probe(const Vector3<Real>& displacement, const Vector3<Real>& rotation) const {
    return bounding_.probe(displacement, rotation);
  }

 private:
  BasicBounding<Real> bounding_;
  std::optional<PortAccount> account_;
};

}  // namespace feltwire
