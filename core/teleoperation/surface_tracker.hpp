#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/teleoperation/low_pass.hpp"

namespace feltwire {

/// Tracks the place of a surface along its normal, and its speed, from a place that is measured
/// each sample.
///
/// A surface stands still until a slow tracker of second order (kTracker) sees more than
/// kStandsStill, and moves until it has seen less for kMoves: a touch that arrives and bounces, or
/// a stiffness that is a little wrong, is no motion. The place of one that stands is the measured
/// one low-passed at kQuickPlace. The speed of one that moves is that of a tracker of third order
/// (kMotion, critically damped, no lag at an even acceleration), and its place is led by it.
/// kBlend: how fast it changes from one to the other.
///
/// Known weakness: a light thing that the robot carries moves, too, and a hand that is told its
/// speed over a delay pushes it on: it bounces.
///
/// Nothing here allocates, throws or reads a clock.
class SurfaceTracker {
 public:
  static constexpr double kQuickPlace = 35.0;   // [Hz]
  static constexpr double kTracker = 5.0;       // [Hz]
  static constexpr double kMotion = 8.0;        // [Hz]
  static constexpr double kBlend = 10.0;        // [Hz]
  static constexpr double kStandsStill = 2e-3;  // [m/s]
  static constexpr double kMoves = 0.5;         // [s]

  /// A touch begins. The surface was at `place` [m], and goes to where it is measured.
  void begin(double measured, double place) noexcept {
    *this = {};
    place_ = place;
    relearn(measured);
  }
  /// From now on another stiffness is measured with: what that changes is no motion.
  void relearn(double measured) noexcept {
    slow_ = quick_ = {measured};
    left_ = moves_ = 0.0;
  }
  /// The axis along which it measures has turned, and every place is farther by that [m].
  void carry(double farther) noexcept {
    place_ += farther;
    slow_.place += farther;
    quick_.place += farther;
  }
  /// `measured` [m]; `elapsed` [s] > 0. `stands`: something else than a motion of the surface
  /// changes what is measured, so the surface counts as standing still. A long time is taken in
  /// steps in which the trackers are stable. After a longer one than kRemembers the surface begins
  /// anew.
  void step(double measured, double elapsed, bool stands = false) noexcept {
    if (!(elapsed <= kRemembers)) {
      begin(measured, measured);
      return;
    }
    const double count = std::max(1.0, std::ceil(elapsed / kLongestStep));
    for (int n = 0; n < static_cast<int>(count); ++n) advance(measured, elapsed / count, stands);
  }

  double place() const noexcept { return place_; }                 // [m]
  double speed() const noexcept { return moves_ * quick_.speed; }  // [m/s]

 private:
  struct Track {
    double place = 0.0, speed = 0.0, pull = 0.0;  // [m], [m/s], [m/s^2]
  };
  static constexpr double kTurn = 2.0 * std::numbers::pi;
  static constexpr double kLongestStep = 10e-3;  // [s] the quick tracker is stable up to 10.3 ms
  static constexpr double kRemembers = 0.64;     // [s]

  void advance(double measured, double elapsed, bool stands) noexcept {
    const double slow = kTurn * kTracker, ahead = measured - slow_.place;
    slow_.speed += elapsed * slow * slow * ahead;
    slow_.place += elapsed * (slow_.speed + 2.0 * slow * ahead);
    const double quick = kTurn * kMotion, off = measured - quick_.place;
    quick_.pull += elapsed * quick * quick * quick * off;
    quick_.speed += elapsed * (quick_.pull + 3.0 * quick * quick * off);
    quick_.place += elapsed * (quick_.speed + 3.0 * quick * off);
    left_ = std::abs(slow_.speed) > kStandsStill ? kMoves : std::max(0.0, left_ - elapsed);
    if (stands) {
      slow_ = {measured};
      quick_ = {measured, (1.0 - low_pass_share(kBlend, elapsed)) * quick_.speed};
      left_ = 0.0;
    }
    moves_ += low_pass_share(kBlend, elapsed) * ((left_ > 0.0 ? 1.0 : 0.0) - moves_);
    place_ += elapsed * speed();
    place_ += low_pass_share(kQuickPlace, elapsed) * (measured - place_);
  }

  Track slow_, quick_;
  double place_ = 0.0;
  double left_ = 0.0;   // [s] that it still counts as moving
  double moves_ = 0.0;  // 0: it stands, 1: it moves
};

}  // namespace feltwire
