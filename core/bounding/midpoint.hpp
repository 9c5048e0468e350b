#pragma once

#include <algorithm>
#include <cstdint>

#include "core/base/numeric.hpp"
#include "core/bounding/law.hpp"
#include "core/bounding/oscillation_detector.hpp"
#include "core/bounding/quantized_rest_position.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// mode `midpoint`: asks the environment half a sample ahead, at x(n) + dx(n)/2, and renders the
/// answer. A zero-order hold of a spring k gives the hand k/2 |dx|^2 in a sample. Asked half a
/// sample ahead, it gives k/4 (|dx(n)|^2 - 2 dx(n).dx(n-1) + |dx(n-1)|^2). This is zero for an even
/// motion and eight times less for a hand that swings at 80 Hz with T = 1 ms.
///
/// A motor that follows its command by L delays the force further, by as much again as L. Asked T/2
/// + L ahead, a wall has no damping for a slow hand, and takes some from a fast one. So it asks as
/// much farther as L, half a sample at most: T/2 + L + min(L, T/2). That gives the wall a damping
/// of k min(L, T/2) (docs/bounding.md, "The margin of a lag").
///
/// This is shaping, not a bound: it makes the hand calm, and the account behind it makes the port
/// passive (core/bounding/account.hpp). It works if the command is made at the device: in process,
/// or from a local contact model.
/// Sources: R. E. Ellis, N. Sarkar, M. A. Jenkins, "Numerical methods for the force reflection of
/// contact", ASME J. Dynamic Systems, Measurement and Control 119, 1997; R. B. Gillespie,
/// M. R. Cutkosky, "Stable user-specific haptic rendering of the virtual wall", ASME IMECE 1996.
///
/// A motor that lags by more than the device tells takes damping from the wall, k times the rest of
/// the lag, and a hand with less damping swings at 11 to 46 Hz, by millimetres (docs/bounding.md,
/// "A lag that is not told"). With each such swing (core/bounding/oscillation_detector.hpp) the
/// scene is asked kLagStep farther ahead, up to kMostUntold. That costs no force. If the swing had
/// another cause, the wall is only more damped than it should be. It is kept: a motor does not
/// become faster.
///
/// For a hand that rests the scene is asked at one place
/// (core/bounding/quantized_rest_position.hpp).
///
/// Half a sample of foresight is not enough for every hand: a light one on a light handle has an
/// eigenfrequency near 140 Hz on 40 kN/m, and swings. Whenever it swings that fast and does not
/// come to rest, the share of the force that is rendered falls to kStepDown of what it was, to
/// kLeastShare at least; then it grows again by kGrowth.
template <class Real>
class Midpoint {
 public:
  static constexpr double kStepDown = 0.85;
  static constexpr double kLeastShare = 0.1;      // no surface is lost to a hand that is shaken
  static constexpr double kGrowth = 0.05;         // [1/s] of the share
  static constexpr double kLeastSwing = 30e-6;    // [m] a finger feels 10 um RMS
  static constexpr double kLagStep = 0.15e-3;     // [s]
  static constexpr double kMostUntold = 0.75e-3;  // [s] more than a motor lags over USB
  /// The least size of a swing in quanta of the encoder, along an axis: two of them, whatever their
  /// sum rounds to. Along another direction u the readings of several axes are added up: it is
  /// |u|_1 times as large.
  static constexpr double kQuanta = 1.9;

  /// `quantum` [m] of the encoder; `period` T [s]; `lag` [s] of the motor, an upper bound.
  Midpoint(double quantum, double period, double lag = 0.0)
      : resting_(quantum),
        period_(period),
        ahead_(kHalf + lag / period + std::min(kHalf, lag / period)),
        quanta_(kQuanta * quantum) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    const Oscillation swing = swings(s);
    if (swing == Oscillation::slow) untold_lag_ = std::min(kMostUntold, untold_lag_ + kLagStep);
    if (swing == Oscillation::fast) {
      share_ = std::max(kLeastShare, kStepDown * share_);
      ++steps_down_;
    } else if (share_ < 1.0) {
      share_ = std::min(1.0, share_ * (1.0 + kGrowth * static_cast<double>(s.hold_time)));
    }
    return share_ < 1.0 ? static_cast<Real>(share_) * s.command : s.command;
  }
  /// The hand moved while another law was in force.
  void moved(const BasicBoundingStep<Real>& s) noexcept { swings(s); }
  void set_held(const BasicCommand<Real>&) noexcept {}
  /// Returns the place at which to ask the environment, relative to the device, which has moved by
  /// `displacement`, `rotation` since the last step.
  BasicProbe<Real> probe(const Vector3<Real>& displacement,
                         const Vector3<Real>& rotation) const noexcept {
    const double ahead = ahead_ + untold_lag_ / period_;
    return {resting_.offset(displacement.template cast<double>(), ahead).template cast<Real>(),
            static_cast<Real>(ahead) * rotation};
  }
  HandCredit hand_credit() const noexcept {
    return {.near_share = share_, .near_steps_down = steps_down_, .untold_lag = untold_lag_};
  }

 private:
  Oscillation swings(const BasicBoundingStep<Real>& s) noexcept {
    const Vec3 displacement = s.displacement.template cast<double>();
    const double time = static_cast<double>(s.hold_time);
    resting_.moved(displacement, time);
    const Vec3 elastic = s.command.elastic.template cast<double>();
    if (const double force = length(elastic); force > 0.0) normal_ = elastic / force;
    return swing_.moved(normal_.dot(displacement), time,
                        std::max(kLeastSwing, quanta_ * normal_.lpNorm<1>()));
  }

  static constexpr double kHalf = 0.5;
  QuantizedRestPosition resting_;
  double period_;  // T [s]
  double ahead_;   // [samples] of the place at which the scene is asked
  double quanta_;  // [m]
  OscillationDetector swing_;
  Vec3 normal_ = Vec3::Zero();  // of the last contact
  double share_ = 1.0;          // of the command that is rendered
  std::uint64_t steps_down_ = 0;
  double untold_lag_ = 0.0;  // [s] beyond the lag that was told
};

}  // namespace feltwire
