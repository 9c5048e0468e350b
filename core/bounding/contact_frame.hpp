#pragma once

#include "core/bounding/channel.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// What happens to the other channels when one is bounded.
enum class Projection {
  joint,  // one factor for elastic and frictional: the command's direction is kept exactly
  cone    // the elastic force keeps its own factor, friction takes the smaller: normal force is not
          // lost to friction
};

/// mode `contact_frame`, the default: direction and passivity together (docs/bounding.md,
/// "contact_frame").
///
/// Two channels, each passive by itself so that neither pays for the other:
///   elastic     magnitude along the contact normal u = elastic / |elastic|
///   frictional  the rest, orthogonal to u
/// and a third for torque. Each keeps S(F) = |F|^2 T / (4 b) and obeys, with c = 2 b / T,
///   S(F(n)) <= S(F(n-1)) + F(n-1).dx_ch(n) + (b/T) |dx_ch(n)|^2   <=>   |F(n)| <= |F(n-1) + c
///   dx_ch(n)|   (C)
/// It is an upper bound on magnitudes only, so saturation, slew limits, fades and dropping to zero
/// are all admissible: any held force that is no longer than the one allowed keeps the port
/// passive. What nature adds (a hold longer than T, a held force longer than the allowed one) is a
/// debt: no force until the device's damping has repaid it. Known weakness: a bound of one sample
/// has no memory of energy spent, so a force once lost comes back only as the hand presses on.
class ContactFrameBound {
 public:
  ContactFrameBound(ChannelLaw translation, ChannelLaw rotation, Projection projection, bool torque)
      : translation_(translation), rotation_(rotation), projection_(projection), torque_(torque) {}

  Command step(const BoundingStep& s) noexcept;
  void set_held(const Command& held) noexcept;
  bool in_debt() const noexcept { return force_debt_.force > 0.0 || torque_debt_.force > 0.0; }

 private:
  ChannelLaw translation_, rotation_;
  Projection projection_;
  bool torque_;

  Vec3 normal_ =
      Vec3::Zero();       // u_p, the elastic direction held; zero when no elastic force was held
  double elastic_ = 0.0;  // [N] held along normal_, >= 0
  Vec3 frictional_ = Vec3::Zero();   // [N] held
  Vec3 held_torque_ = Vec3::Zero();  // [N m]
  double allowed_force_ = 0.0,
         allowed_torque_ = 0.0;  // by the last step: sqrt(4 b / T times what is stored)
  double force_excess_ = 0.0,
         torque_excess_ = 0.0;     // what was held beyond that, owed from the next step on
  Debt force_debt_, torque_debt_;  // one a port: both force channels repay it
};

}  // namespace feltwire
