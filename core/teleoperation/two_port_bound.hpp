#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/numeric.hpp"
#include "core/bounding/channel.hpp"
#include "core/bounding/frame.hpp"

namespace feltwire {

/// The two-port law: a bound at a leader's device that lets the remote environment push the hand
/// with at most the energy that it gave.
///
///   |F(n)|^2 <= max(|F(n-1) + c dx(n)|^2, 2 c (W(n) + E(n))),     c = 2 b / T           (T)
///
/// F resists the motion (f = -F is on the hand). W(n) = sum F(i-1).dx(i) is the work that the hand
/// paid in this contact, E(n) the energy that the remote environment gave (RemoteEnergy::net()).
/// The claim, for every hand, command, network and E:
///   delivered to the hand(n) <= burned by the device(n) + max over m <= n of E(m)
/// docs/teleoperation.md has the proof. Every reduction of the force is admissible. A hold h > T
/// burns only (b/h)|dx|^2; the energy overdrawn in it is a debt, as in contact_frame.
///
/// There is one channel: the whole force is scaled, so it keeps its direction. Known weakness: if
/// the remote gives nothing, a late force fades, as under contact_frame.
class TwoPortBound {
 public:
  /// b [N s/m] > 0 of the device in every direction; T [s] > 0.
  TwoPortBound(double damping, double period) : law_{2.0 * damping / period, period} {}

  struct Sample {
    Vec3 displacement = Vec3::Zero();  // [m] while the last force was held
    double hold_time = 0.0;            // [s]
    Vec3 command = Vec3::Zero();       // [N] on the hand
    double remote = 0.0;               // E [J]
  };

  /// Returns the force on the hand [N]. A sample with a value that is not finite renders no force,
  /// and the stored energy is lost.
  Vec3 step(const Sample& s) noexcept {
    const Vec3 before = held_;
    held_.setZero();
    if (!s.displacement.allFinite() || !std::isfinite(s.hold_time)) {
      // The last force was paid for, for every movement. The rest of W is not known.
      work_ = -std::numeric_limits<double>::infinity();
      return held_;
    }
    work_ -= before.dot(s.displacement);
    double first = allowed_magnitude(
        length(before - law_.c * s.displacement), [&] { return length(s.displacement); },
        s.hold_time, law_, debt_);
    first = debt_.repay(first);
    const double paid = std::isfinite(s.remote) ? work_ + s.remote : 0.0;
    const double second = std::sqrt(2.0 * law_.c * std::max(0.0, paid));
    if (!s.command.allFinite()) return held_;
    held_ = reduction(std::max(first, second), length(s.command)) * s.command;
    return held_;
  }

  /// Sets the force that was really held after the last step, if it is less.
  void set_held(const Vec3& held) noexcept { held_ = held; }

  /// A new contact. Precondition: no force is held.
  void begin_contact() noexcept { work_ = 0.0; }

  double work() const noexcept { return work_; }  // W [J]

 private:
  ChannelLaw<double> law_;
  Debt<double> debt_;
  Vec3 held_ = Vec3::Zero();  // f(n-1) [N] on the hand
  double work_ = 0.0;
};

}  // namespace feltwire
