#pragma once
// The energy that a share of a force needs where the motor follows its commands with a lag.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/bounding/account.hpp"
#include "core/bounding/lagging_forces.hpp"

namespace feltwire {

/// The energy [J] that one port needs from this sample on, if a share s of a wanted force is
/// commanded now and nothing after it:
///
///   need(s) = sum over the samples i = 0, 1, ... in which a part of s f may be on the hand, of
///             sum over j = 0, 1, ... of (w(j) - w(j+1)) max(need_i(s f), need_i(f_1), ...
///             need_i(f_j)) and the TurnLimit of each change of force that may happen in it
///
/// f_j is the older force j, and w(j) the most that it and those before it make up of the mean
/// force of sample i; w(0) is that of s f with all of them. need_i is the need in sample i, whose
/// reach is longer by what may drive the handle before it. docs/bounding.md, "A motor that lags",
/// has the proof: s = 0 is always within the balance.
///
/// A device that takes forces up L samples late takes up s f after L samples. Sample 0 above is
/// then sample L from now, and the forces that are still to come are among the older ones.
class LaggingNeed {
 public:
  /// `hold` [s]: the time of each sample, T or longer. `older`: the forces before the wanted one
  /// when the device takes it up, after `late` samples. `driving` [N]: the strongest force that may
  /// be on the motor until then, at least older.strongest().
  LaggingNeed(const PortBalance& port, const LaggingForces& older, const Vec3& wanted, double hold,
              int late, double driving) noexcept;
  /// The device takes the force up at once.
  LaggingNeed(const PortBalance& port, const LaggingForces& older, const Vec3& wanted,
              double hold) noexcept
      : LaggingNeed(port, older, wanted, hold, 0, older.strongest()) {}

  bool limited() const noexcept { return limited_; }
  double at(double s) const noexcept {
    double sum = 0.0;
    for (std::size_t i = 0; i < count_; ++i) sum += of_sample(i, s);
    return sum;
  }
  /// The part of it in the sample in which the device takes the force up.
  double of_first_sample(double s) const noexcept { return of_sample(0, s); }

 private:
  static constexpr std::size_t kMost = LaggingForces::kMost;
  struct OfSample {
    EnergyNeed wanted{};
    double rounded = 0.0;                   // [J] of the whole of the wanted force
    double weight = 0.0;                    // w(0)
    std::array<double, kMost + 1> older{};  // w(1), w(2), ...; then 0
    std::array<double, kMost> worst{};      // [J] max(need_i(f_1), ... need_i(f_j))
    std::size_t count = 0;                  // of the older forces that may act in it
    double ends = 0.0, begins = 0.0;        // TurnLimit::spread() of w(0) and w(1)
    double changes = 0.0;                   // [J] TurnLimit of the changes among the older forces
  };
  double of_sample(std::size_t i, double s) const noexcept;

  TurnLimit turns_{};
  double length_ = 0.0, squared_ = 0.0;        // |f| [N], f.f [N^2]
  double along_ = 0.0, newest_squared_ = 0.0;  // f.c, c.c [N^2] with c the newest older force
  bool limited_ = true;
  std::array<OfSample, kMost> samples_{};
  std::size_t count_ = 0;
};

/// The largest s of 0 to 1 at which `cost` is at most `most`: one at which it was found to be so, a
/// little less than the largest. `cost` grows and is convex. 0 if there is none.
template <class Cost>
double largest_within(double most, Cost cost) noexcept {
  if (!(most > 0.0)) return 0.0;
  double above = cost(1.0) - most;
  if (above <= 0.0) return 1.0;
  double below = cost(0.0) - most;
  if (!(below < 0.0)) return 0.0;
  // A convex cost lies below its chord: where the chord meets `most`, s is within. A
  // parabola through three of its points gives a better guess, which may be beyond.
  constexpr int kSteps = 3;
  double low = 0.0, high = 1.0;
  for (int n = 0; n < kSteps; ++n) {
    const double chord = low - below * (high - low) / (above - below);
    if (!(chord > low)) break;
    const double at_chord = cost(chord) - most;
    if (at_chord > 0.0) {  // by rounding
      high = chord, above = at_chord;
      continue;
    }
    // The parabola through the three points, from (chord, at_chord) on.
    const double slope = (above - at_chord) / (high - chord);
    const double bend = (slope - (at_chord - below) / (chord - low)) / (high - low);
    const double linear = slope - bend * (high - chord);
    low = chord, below = at_chord;
    const double root = linear * linear - 4.0 * bend * at_chord;
    const double step = -2.0 * at_chord / (linear + std::sqrt(std::max(0.0, root)));
    const double guess = chord + step;
    if (!(guess > low && guess < high)) continue;
    const double over = cost(guess) - most;
    if (over <= 0.0)
      low = guess, below = over;
    else
      high = guess, above = over;
  }
  return low;
}

}  // namespace feltwire
