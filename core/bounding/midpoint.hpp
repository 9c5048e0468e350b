#pragma once

#include "core/bounding/resting_place.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// mode `midpoint`: asks the environment half a sample ahead, at x(n) + dx(n)/2, and renders the
/// answer. A zero-order hold of a spring k gives the hand k/2 |dx|^2 in a sample. Asked half a
/// sample ahead, it gives k/4 (|dx(n)|^2 - 2 dx(n).dx(n-1) + |dx(n-1)|^2). This is zero for an even
/// motion and eight times less for a hand that swings at 80 Hz with T = 1 ms.
///
/// This is shaping, not a bound: it makes the hand calm, and the account behind it makes the port
/// passive (core/bounding/account.hpp). It works if the command is made at the device: in process,
/// or from a local contact model.
/// Sources: R. E. Ellis, N. Sarkar, M. A. Jenkins, "Numerical methods for the force reflection of
/// contact", ASME J. Dynamic Systems, Measurement and Control 119, 1997; R. B. Gillespie,
/// M. R. Cutkosky, "Stable user-specific haptic rendering of the virtual wall", ASME IMECE 1996.
///
/// For a hand that rests the scene is asked at one place (core/bounding/resting_place.hpp).
template <class Real>
class Midpoint {
 public:
  /// `quantum` [m] of the encoder.
  explicit Midpoint(double quantum) : resting_(quantum) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    resting_.moved(s.displacement.template cast<double>(), static_cast<double>(s.hold_time));
    return s.command;
  }
  void set_held(const BasicCommand<Real>&) noexcept {}
  /// Returns the place at which to ask the environment, relative to the device, which has moved by
  /// `displacement`, `rotation` since the last step.
  BasicProbe<Real> probe(const Vector3<Real>& displacement,
                         const Vector3<Real>& rotation) const noexcept {
    constexpr Real kHalf = 0.5;
    return {resting_.offset(displacement.template cast<double>()).template cast<Real>(),
            kHalf * rotation};
  }

 private:
  RestingPlace resting_;
};

}  // namespace feltwire
