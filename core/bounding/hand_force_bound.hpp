#pragma once
// Learns the largest recent force from outside: a smaller bound than the specified one.

#include "core/base/types.hpp"
#include "core/bounding/reachable_displacement.hpp"

namespace feltwire {

/// Learns an upper bound of the force from outside of one port from the movement it causes.
///
/// Over two blocks of N = 8 samples with the displacements D0, D1 a mass m under a force F from
/// outside, the same throughout, and the held forces f(i) moves by
///
///   D1 - D0 = (N T)^2 / m (F + w),   w = sum of the f(i), the later the more in the first block,
///                                        the earlier the more in the second; weights add up to 1
///
/// so F = m (D1 - D0) / (N T)^2 - w, wrong by 2 m q |u|_1 / (N T)^2 at most for the encoder. The
/// learned bound is kMargin times the largest F of the last two windows of kWindow seconds, from
/// kLeastShare of the specified force to all of it. A hand's force that changes within N
/// samples, and friction, are seen in part only: the learned bound is an assumption about
/// the hand, like the specified one. A sample that it does not explain ends it: then the specified
/// bound holds again, and two windows start again.
class HandForceBound {
 public:
  static constexpr int kSamples = 8;           // N
  static constexpr double kMargin = 1.5;       // the largest force to come over the largest seen
  static constexpr double kLeastShare = 0.25;  // of the specified one
  static constexpr double kWindow = 10.0;      // [s]

  /// Precondition: validate(known) passed, mass and outside force are known, period > 0 [s].
  HandForceBound(const PortKnowledge& known, double period)
      : mass_(known.mass), quantum_(known.quantum), told_(known.outside_force), period_(period) {}

  /// The handle moved by `displacement` over `hold_time` [s] while `held` acted.
  void moved(const Vec3& displacement, const Vec3& held, double hold_time) noexcept;
  /// A sample showed a stronger force than bound() explains.
  void exceeded() noexcept;
  /// The last movement is not known.
  void forget() noexcept { begin(Block{}, false); }

  /// Returns the learned bound of the force from outside [N].
  double bound() const noexcept { return bound_; }

 private:
  struct Block {
    Vec3 way = Vec3::Zero();  // [m]
    Vec3 rising =
        Vec3::Zero();  // [N] sum of the held forces, with the largest weight for the latest
    Vec3 falling = Vec3::Zero();  // [N] the same, with the largest weight for the earliest
    int samples = 0;
  };
  void begin(const Block& before, bool known) noexcept {
    before_ = before;
    known_before_ = known;
    block_ = {};
  }
  void look() noexcept;
  void pass(double time) noexcept;

  double mass_, quantum_, told_, period_;
  Block before_, block_;
  bool known_before_ = false;
  double largest_ = 0.0, largest_before_ = told_;  // [N] in this window, in the one before it
  double time_ = 0.0;                              // [s] of this window
  double bound_ = told_;
};

}  // namespace feltwire
