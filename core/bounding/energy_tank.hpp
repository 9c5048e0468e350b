#pragma once

#include <algorithm>

#include "core/bounding/frame.hpp"

namespace feltwire {

/// mode `energy_tank`: the least conservative vector form of the energy bound, for comparison.
///
/// Every channel of the contact (elastic, frictional, torque) has a tank. It holds the energy that
/// its port took in, with the device's damping, in the coordinates of Metric:
///   E += dx' B dx / h - F'.dx   with F' = f(n-1) on the hand,
///   |f(n)| <= sqrt(4 E / (T u' B^-1 u))                     u = f / |f|
/// The limit is the force from which the hand can take back the whole tank in the next sample. A
/// channel is emptied when its command ends (contact lost), so that no energy goes from one contact
/// to the next.
/// Source: the energy bounding algorithm (Kim & Ryu, "Robustly stable haptic interaction control
/// using an energy-bounding algorithm", Int. J. Robotics Research 2010) with all of the energy kept
/// that its storage throws away; tanks after Franken et al., "Bilateral telemanipulation with time
/// delays: a two-layer approach combining passivity and transparency", IEEE Trans. Robotics 2011.
/// Passive like contact_frame, and an upper bound on magnitudes like it.
/// Known weakness: while a contact lasts, the tank gathers all energy that the damping burned, and
/// friction fills its own tank; a later oscillation uses it until the tank is empty.
template <class Real>
class EnergyTankBound {
 public:
  EnergyTankBound(const Metric<Real>& translation, const Metric<Real>& rotation, Real period,
                  bool torque)
      : translation_(translation), rotation_(rotation), period_(period), torque_on_(torque) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    const ChannelCommand<Real> command = in_channels(s.command, translation_);
    take_in(command.normal, translation_.movement(s.displacement), s.hold_time);

    const Real elastic = std::abs(command.elastic), friction = length(command.frictional);
    if (!(elastic > 0)) elastic_ = std::min(elastic_, Real(0));
    if (!(friction > 0)) frictional_ = std::min(frictional_, Real(0));
    ChannelScales<Real> scale{reduction(allowed(elastic_, translation_), elastic),
                              reduction(allowed(frictional_, translation_), friction)};
    scale.frictional = std::min(scale.frictional, scale.elastic);
    // A pull along the normal is only a part of friction; alone it must not remain.
    if (command.elastic < 0) scale.elastic = scale.frictional;
    held_.set(command.normal, scale.elastic * command.elastic,
              scale.frictional * command.frictional);

    BasicCommand<Real> rendered = held_back(command, scale, translation_);
    if (torque_on_) rendered.torque = bound_torque(s);
    return rendered;
  }

  void set_held(const BasicCommand<Real>& held) noexcept {
    held_.set(held, translation_);
    held_torque_ = rotation_.force(held.torque);
  }

  bool in_debt() const noexcept { return elastic_ < 0 || frictional_ < 0 || rotational_ < 0; }

 private:
  void take_in(const Vector3<Real>& normal, const Vector3<Real>& moved, Real hold_time) noexcept {
    const HeldFrame<Real> f(held_, normal, moved);
    const Real b = translation_.damping();
    if (f.reframed && b > 0) {
      // The force that changes its channel takes its storage along. Otherwise one tank would fall
      // below zero while the other renders from energy that it no longer owns.
      const Real moved_storage = f.elastic * f.elastic * (period_ / (4 * b));
      elastic_ += moved_storage;
      frictional_ -= moved_storage;
    }
    elastic_ += b / hold_time * f.dx_elastic * f.dx_elastic - f.elastic * f.dx_elastic;
    frictional_ +=
        b / hold_time * f.dx_frictional.squaredNorm() - f.frictional.dot(f.dx_frictional);
    // The other channel pays for an overdrawn one (a hold that is too long, a force that was never
    // allowed).
    if (elastic_ < 0) settle(elastic_, frictional_);
    if (frictional_ < 0) settle(frictional_, elastic_);
  }

  static void settle(Real& owing, Real& other) noexcept {
    const Real paid = std::min(-owing, std::max(Real(0), other));
    owing += paid;
    other -= paid;
  }

  Real allowed(Real energy, const Metric<Real>& metric) const noexcept {
    return std::sqrt(4 * metric.damping() / period_ * std::max(Real(0), energy));
  }

  Vector3<Real> bound_torque(const BasicBoundingStep<Real>& s) noexcept {
    const Vector3<Real> turned = rotation_.movement(s.rotation);
    const Vector3<Real> wanted = rotation_.force(s.command.torque);
    rotational_ +=
        rotation_.damping() / s.hold_time * turned.squaredNorm() - held_torque_.dot(turned);
    const Real magnitude = length(wanted);
    if (!(magnitude > 0)) rotational_ = std::min(rotational_, Real(0));
    const Real scale = reduction(allowed(rotational_, rotation_), magnitude);
    held_torque_ = scale * wanted;
    return scale * s.command.torque;
  }

  Metric<Real> translation_, rotation_;
  Real period_;
  bool torque_on_;
  Real elastic_ = 0, frictional_ = 0, rotational_ = 0;  // [J] the tanks; below zero: a debt
  HeldForce<Real> held_;
  Vector3<Real> held_torque_ = Vector3<Real>::Zero();
};

}  // namespace feltwire
