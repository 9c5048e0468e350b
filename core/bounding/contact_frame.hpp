#pragma once

#include "core/bounding/bounding_config.hpp"
#include "core/bounding/channel.hpp"
#include "core/bounding/frame.hpp"

namespace feltwire {

/// mode `contact_frame`, the default: direction and passivity together (docs/bounding.md,
/// "contact_frame").
///
/// Two channels, each passive by itself so that neither pays for the other:
///   elastic     magnitude along the contact normal u = elastic / |elastic|
///   frictional  the rest, orthogonal to u
/// and a third for torque. Each keeps S(F) = |F|^2 T / (4 b) and obeys, with c = 2 b / T,
///   S(F(n)) <= S(F(n-1)) + F(n-1).dx_ch(n) + (b/T) |dx_ch(n)|^2   <=>   |F(n)| <= |F(n-1) + c
///   dx_ch(n)|   (C)
/// It is an upper bound on magnitudes only. So saturation, slew limits, fades and dropping to zero
/// are admissible: any held force that is no longer than the allowed one keeps the port passive. A
/// hold longer than T, or a held force longer than the allowed one, makes a debt: there is no force
/// until the device's damping has repaid it.
///
/// With Storage::elastic the elastic channel keeps, beside S(F), a spare energy E: the work of the
/// spring, sum 1/2 (F(n-1) + F(n)) dx_el(n), as far as the port really took it in. The left side of
/// (C) may then use it. Dissipation (of the device, the contact and friction) never enters, and a
/// lost contact empties it. So no energy accumulates that a later oscillation could spend.
/// Known weakness: a lost force comes back only as the hand presses on.
/// contact_frame_template.hpp has the definitions, for arithmetics other than double.
template <class Real>
class ContactFrameBound {
 public:
  /// `translation` and `rotation` hold the damping, `period` is T [s].
  ContactFrameBound(const Metric<Real>& translation, const Metric<Real>& rotation, Real period,
                    Projection projection, Storage storage, bool torque)
      : translation_(translation),
        rotation_(rotation),
        force_law_{2 * translation.damping() / period, period},
        torque_law_{2 * rotation.damping() / period, period},
        projection_(projection),
        storage_(storage),
        torque_(torque) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept;
  void set_held(const BasicCommand<Real>& held) noexcept;
  /// The elastic channel of the next step may use `energy` [J] beside its store. The caller must
  /// know that the port has it (client/servo/scene_change_gate.hpp).
  void endow(Real energy) noexcept {
    constexpr Real kTwo = 2;
    endowed_ = std::sqrt(kTwo * force_law_.c * energy);
  }
  bool in_debt() const noexcept { return force_debt_.force > 0 || torque_debt_.force > 0; }

 private:
  /// The data of the last step from which set_held() computes the stored energy.
  struct ElasticStep {
    Real stored = 0;           // [N] sqrt(2 c E) before the step
    Real spring = 0;           // [N] the held force without contact damping, before the step
    Real pressed = 0;          // [N] c times the movement into the surface during the step
    Real allowed = 0;          // [N]
    Real rendered = 0;         // [N]
    Real rendered_spring = 0;  // [N] without contact damping
  };
  ChannelScales<Real> bound_force(const ChannelCommand<Real>& command,
                                  const Vector3<Real>& displacement, Real hold_time) noexcept;
  Real bound_torque(const Vector3<Real>& command, const Vector3<Real>& rotation,
                    Real hold_time) noexcept;
  void store() noexcept;

  Metric<Real> translation_, rotation_;  // below, forces and movements are in their coordinates
  ChannelLaw<Real> force_law_, torque_law_;
  Projection projection_;
  Storage storage_;
  bool torque_;

  HeldForce<Real> held_;
  Real spare_ = 0;    // [N] stored beyond S(held_.elastic): sqrt(2 c E - elastic^2)
  Real endowed_ = 0;  // [N] the same for the next step alone
  Real spring_ = 0;   // [N] of held_.elastic without contact damping
  ElasticStep last_;
  Vector3<Real> held_torque_ = Vector3<Real>::Zero();  // [N m]
  Real allowed_force_ = 0,
       allowed_torque_ = 0;  // allowed in the last step: sqrt(4 b / T x stored energy)
  Real force_excess_ = 0, torque_excess_ = 0;  // held beyond that; a debt from the next step on
  Debt<Real> force_debt_, torque_debt_;        // one for each port: both force channels repay it
};

extern template class ContactFrameBound<double>;

}  // namespace feltwire
