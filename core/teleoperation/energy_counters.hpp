#pragma once
// Counts the energy that an environment exchanges with a robot. The counts stay correct if a
// network loses, repeats or reorders them.

#include <algorithm>
#include <cmath>

#include "core/base/types.hpp"

namespace feltwire {

/// Totals since the session began. They only grow. So the later of two states has the larger
/// totals. A lost, repeated or overtaken state changes nothing once a newer one was received.
struct EnergyCounters {
  double given = 0.0;   // [J] by the environment to the robot
  double taken = 0.0;   // [J] by the environment from the robot
  double pushed = 0.0;  // [J] sum over the contacts of the largest given - taken in each
};

/// Counts at the robot, once a sample. The energy that the environment gives is counted as a lower
/// bound, the energy that it takes as an upper bound, so that the sensor's noise cannot become
/// energy.
class ContactEnergy {
 public:
  /// `noise` [N] >= 0: the largest error of the measured force.
  explicit ContactEnergy(double noise) : noise_(noise) {}

  /// The robot's tool moved by `displacement` [m]. `force` [N]: the environment's on the tool, at
  /// the end of the movement; the work is that of the mean of both ends. A contact ends where the
  /// force stays within the noise for kApart; `elapsed` [s] since the last call. A movement or a
  /// force that is not finite counts as nothing.
  void moved(const Vec3& force, const Vec3& displacement, double elapsed) noexcept {
    const double work = 0.5 * (force_ + force).dot(displacement) - noise_ * displacement.norm();
    force_ = force;
    if (!std::isfinite(work)) {
      force_.setZero();
      return;
    }
    (work > 0.0 ? counters_.given : counters_.taken) += std::abs(work);
    apart_ = force.norm() > noise_ ? 0.0 : apart_ + elapsed;
    if (apart_ >= kApart) net_ = largest_ = 0.0;
    net_ += work;
    if (net_ > largest_) {
      counters_.pushed += net_ - largest_;
      largest_ = net_;
    }
  }
  const EnergyCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr double kApart = 0.02;  // [s]
  double noise_;
  EnergyCounters counters_;
  Vec3 force_ = Vec3::Zero();
  double net_ = 0.0, largest_ = 0.0;  // [J] in this contact
  double apart_ = 0.0;                // [s] without force
};

/// The trust of the leader in the energy that a follower reports. Zero: no trust, for a follower
/// that is not one's own. The defaults are for one's own robot.
struct RemoteTrust {
  double per_contact = 0.1;  // [J] while the leader's force does not vanish
  double power = 5.0;        // [W]
};

/// At the leader: the energy that the remote environment gave, as far as it is trusted. Over a step
/// of h seconds the credit grows by the growth of `pushed`, but by at most power h; in one contact
/// of the leader by at most per_contact. The excess is never credited later.
class RemoteEnergy {
 public:
  /// Precondition: both limits are finite and not negative.
  explicit RemoteEnergy(const RemoteTrust& trust) : trust_(trust) {}

  /// Takes counters in any order, any number of times. It ignores counters that are not finite, or
  /// smaller than the largest seen.
  void take(const EnergyCounters& seen) noexcept {
    if (!std::isfinite(seen.given) || !std::isfinite(seen.taken) || !std::isfinite(seen.pushed))
      return;
    seen_.given = std::max(seen_.given, seen.given);
    seen_.taken = std::max(seen_.taken, seen.taken);
    seen_.pushed = std::max(seen_.pushed, seen.pushed);
    if (!restarted_) return;
    restarted_ = false;
    begun_ = seen_;
    credited_ = seen_.pushed;
  }

  /// The next counters are those of another robot, and begin a new contact. Their totals so far are
  /// no growth.
  void restart() noexcept {
    seen_ = {};
    begin_contact();
    credited_ = 0.0;
    restarted_ = true;
  }

  /// Advances the time by `elapsed` [s]. Returns the growth of the credit [J].
  double step(double elapsed) noexcept {
    const double time = std::isfinite(elapsed) ? std::max(0.0, elapsed) : 0.0;
    const double most = std::min(trust_.power * time, trust_.per_contact - in_contact_);
    const double grown = std::clamp(seen_.pushed - credited_, 0.0, std::max(0.0, most));
    credited_ = seen_.pushed;
    in_contact_ += grown;
    credit_ += grown;
    return grown;
  }

  /// The leader's force became zero: a new contact begins.
  void begin_contact() noexcept {
    begun_ = seen_;
    in_contact_ = 0.0;
  }

  /// [J] E of the two-port law (T): given - taken in this contact, as far as it is trusted.
  double net() const noexcept {
    return std::min((seen_.given - begun_.given) - (seen_.taken - begun_.taken), in_contact_);
  }
  double credit() const noexcept { return credit_; }  // [J] in all

 private:
  RemoteTrust trust_;
  EnergyCounters seen_, begun_;
  double credited_ = 0.0;    // [J] part of `pushed` that was considered
  double in_contact_ = 0.0;  // [J] credited in this contact
  double credit_ = 0.0;
  bool restarted_ = false;
};

}  // namespace feltwire
