// A port (translation or rotation) of the energy account. It computes the energy that a sample
// earns, and the need of a force: the largest energy that the force can give to the hand in the
// next sample.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/numeric.hpp"
#include "core/bounding/account.hpp"

namespace feltwire {

PortBalance::PortBalance(const PortKnowledge& known, double period, bool learns)
    : known_(known),
      period_(period),
      directional_(!known.damping.isotropic() && known.damping.least() > 0.0),
      reach_(known),
      path_(known.quantum),
      limits_speed_(known.speed < std::numeric_limits<double>::infinity()) {
  if (directional_) inverse_damping_ = known.damping.matrix().inverse();
  if (learns && reach_.bounds()) learned_.emplace(known, period);
}

/// Computes the share of the balance to keep in reserve, so that a late tick reduces the force only
/// gradually. Forces act L samples late. Let f be a force so small that its need is f d, where d is
/// the reachable displacement (d_n in the n-th sample). L + 1 such forces act in a row. After the
/// late tick, each d is longer by delta, and the next force is f'. Then f' (d_L + delta) = f (d_L -
/// L delta) + the kept part of f (d_0 + ... + d_L). For a force direction u between an axis and a
/// diagonal, the kept part grows nearly with the square of |u|_1.
void PortBalance::keep_for_late_ticks(int late) noexcept {
  // In both cases, a tool that begins to press gets its full force.
  if (late == 0 || !reach_.bounds()) return;
  constexpr double kLate = 0.5;  // delay of a tick, in periods T
  constexpr double kMost = 0.1;  // largest share of a balance that is kept
  constexpr int kSamples = 4;    // number of samples; reach_ stores fewer
  const Vec3 none = Vec3::Zero();
  ReachableDisplacement before(known_);
  for (int n = 0; n < kSamples; ++n) before.moved(none, none, period_, period_);
  ReachableDisplacement after = before;
  after.moved(none, none, (1.0 + kLate) * period_, period_);
  const auto kept_along = [&](const Vec3& u) {
    const double first = before.along(u, 1.0, period_);
    const double longer = after.along(u, 1.0, period_) - first;
    const double more = before.driven(u, 1.0, {&none, 1}, period_);
    const double last = first + late * more, all = (late + 1) * (first + 0.5 * late * more);
    return std::min(kMost, ((late + kSoftFall) * longer - (1.0 - kSoftFall) * last) / all);
  };
  const Vec3 diagonal = Vec3::Ones().normalized();
  kept_ = kept_along(Vec3::UnitX());
  kept_aside_ = 0.5 * (kept_along(diagonal) - kept_);
  keeps_ = most_kept() > 0.0;
}

double PortBalance::damping_along(const Vec3& force) const noexcept {
  if (known_.damping.isotropic()) return known_.damping.matrix()(0, 0);
  // A force along a damped direction may also move the handle along a direction without damping.
  return directional_ ? force.squaredNorm() / force.dot(inverse_damping_ * force) : 0.0;
}

void PortBalance::forget() noexcept {
  reach_.forget();
  path_.forget();
  if (learned_) learned_->forget();
  strong_hand_ = false;
  too_fast_ = false;
}

PortBalance::Hold PortBalance::hold_of(double damping, double hold_time) const noexcept {
  const double k = reach_.per_newton(hold_time), burned = damping / hold_time;
  return {
      .time = hold_time,
      .free = damping > 0.0 ? hold_time / (2.0 * damping) : std::numeric_limits<double>::infinity(),
      .burned = burned,
      .per_newton = k,
      .second = k * (1.0 - burned * k),
      .linear = 1.0 - 2.0 * burned * k};
}

void PortBalance::prepare(double hold_time) noexcept {
  if (directional_ || hold_.time == hold_time) return;
  const bool same_everywhere = known_.damping.isotropic();
  hold_ = hold_of(same_everywhere ? known_.damping.matrix()(0, 0) : 0.0, hold_time);
}

inline bool PortBalance::beyond_reach(const Vec3& displacement, const Vec3& held,
                                      double hold_time) const noexcept {
  if (!reach_.known() || reach_.goes_on(displacement, hold_time)) return false;
  const double squared = displacement.squaredNorm();
  if (squared == 0.0) return false;
  // Allow for rounding errors, because a movement of one encoder quantum is often exactly at the
  // limit.
  return squared >
         (1.0 + kOffByRounding) * reach_.along(displacement, std::sqrt(squared), held, hold_time);
}

/// Returns the energy [J] that the sample is charged for the lag of the motor. During a uniform
/// movement, only the mean force counts. At most share(j) of the mean comes from the older force j
/// and the forces before j. So the slice share(j) - share(j + 1) is charged with the worst of the
/// forces up to j. `turns` adds the energy for a hand that reverses within the sample.
double PortBalance::charged_for_lag(const Vec3& displacement, const Vec3& held, double hold_time,
                                    const LaggingForces& older) const noexcept {
  double charged = 0.0, worst = 0.0, slice = 0.0;
  const TurnLimit turns = turn_limit(std::max(length(held), older.strongest()), hold_time);
  const Vec3* newer = &held;
  for (std::size_t i = 0; i < older.count(); ++i) {
    const double share = older.share(older[i].age, 0.0, hold_time);
    charged += (slice - share) * worst +
               turns.energy(length(older[i].force - *newer), TurnLimit::spread(share));
    worst = std::max(worst, (older[i].force - held).dot(displacement));
    slice = share;
    newer = &older[i].force;
  }
  charged += slice * worst;
  return charged;
}

TurnLimit PortBalance::turn_limit(double strongest, double hold_time) const noexcept {
  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  const double b = known_.damping.least();
  return {.by_damping = b > 0.0 ? hold_time / (4.0 * b) : kUnlimited,
          .by_mass = reach_.bounds() ? reach_.per_newton(hold_time) : kUnlimited,
          .outside = (reach_.bounds() ? outside_force() : 0.0) + strongest};
}

double PortBalance::earned(const Vec3& displacement, const Vec3& held, double hold_time,
                           const LaggingForces& older) noexcept {
  const std::size_t lagging = older.lag().time > 0.0 ? older.count() : 0;
  const double lagged = lagging > 0 ? charged_for_lag(displacement, held, hold_time, older) : 0.0;
  if (limits_speed_) {
    const double squared = displacement.squaredNorm();
    too_fast_ = squared > reach_.at_full_speed(displacement, std::sqrt(squared), hold_time);
  }
  if (reach_.bounds() || limits_speed_) {
    const Vec3* drives = &held;  // the force that pushes most along the displacement
    for (std::size_t i = 0; i < lagging; ++i)
      if (older[i].force.dot(displacement) > drives->dot(displacement)) drives = &older[i].force;
    const bool too_far = beyond_reach(displacement, *drives, hold_time);
    strong_hand_ = too_far || too_fast_;
    if (learned_) {
      learned_->moved(displacement, held, hold_time);
      if (too_far) learned_->exceeded();
      reach_.set_outside_force(learned_->bound());
    }
    reach_.moved(displacement, held, hold_time, period_, lagging > 0 ? older.strongest() : -1.0);
  }
  const double rubbed =
      known_.coulomb_friction > 0.0 ? known_.coulomb_friction * path_.moved(displacement) : 0.0;
  return known_.damping.quadratic(displacement) / std::max(period_, hold_time) + rubbed -
         held.dot(displacement) - lagged;
}

// Limits the need by the inertia of the handle. The force F = s |wanted| gives the energy F y -
// (b/h) y^2 to the hand, with the movement y, the damping b and the hold time h. The movement is at
// most d(F) = d0 + k F. Without this limit, the largest energy is F^2 h/(4b) at y = F h/(2b). If
// this y exceeds d(F), the need is the energy at y = d(F).
inline void PortBalance::limit_by_inertia(EnergyNeed& need, const Force& force, const Hold& hold,
                                          double farther) const noexcept {
  const double k = hold.per_newton;
  if (!(k < hold.free)) return;  // With so much damping, F h/(2b) never exceeds d(F).
  need.reach = reach_.along(force.vector, force.length, hold.time) + farther;
  need.free = (hold.free - k) * force.squared;
  need.second = hold.second * force.squared;
  need.linear = hold.linear * need.reach;
  need.burned = hold.burned * need.reach * need.reach;
  need.squared = force.squared;
}

template <class Farther>
EnergyNeed PortBalance::need_of(const Vec3& wanted, double hold_time,
                                Farther farther) const noexcept {
  EnergyNeed need;
  const double squared = wanted.squaredNorm();
  if (squared == 0.0) return need;
  const Force force{wanted, squared, std::sqrt(squared)};
  const bool prepared = !directional_ && hold_.time == hold_time;
  const Hold other = prepared ? Hold{} : hold_of(damping_along(wanted), hold_time);
  const Hold& hold = prepared ? hold_ : other;
  need.first = 0.5 * hold.free * squared;
  if (reach_.known()) limit_by_inertia(need, force, hold, farther(force.length));
  // Skip the speed limit after the handle has exceeded it, because the handle may do so again.
  if (limits_speed_ && !too_fast_) limit_by_speed(need, force, hold);
  return need;
}

EnergyNeed PortBalance::need(const Vec3& wanted, double hold_time,
                             std::span<const Vec3> coming) const noexcept {
  return need_of(wanted, hold_time,
                 [&](double length) { return reach_.driven(wanted, length, coming, hold_time); });
}

/// Returns the need of `wanted` after `samples` earlier samples. The speed gained in an earlier
/// sample moves the handle for the whole sample. The speed gained in this sample counts for half a
/// sample.
EnergyNeed PortBalance::need_after(const Vec3& wanted, double hold_time, int samples,
                                   double strongest) const noexcept {
  return need_of(wanted, hold_time, [&](double length) {
    return length * reach_.per_newton(hold_time) *
           (2.0 * samples * (strongest + outside_force()) + strongest);
  });
}

double PortBalance::need_of_any_hand(const Vec3& wanted, double hold_time) const noexcept {
  const double squared = wanted.squaredNorm();
  if (squared == 0.0) return 0.0;
  return 0.5 * hold_of(damping_along(wanted), hold_time).free * squared;
}

/// Limits the need by the largest speed of the handle. The limits by inertia and by speed hold at
/// every share of the force. Use only the limit that is smaller at the whole force, because both
/// limits together give only a slightly smaller maximum.
void PortBalance::limit_by_speed(EnergyNeed& need, const Force& force,
                                 const Hold& hold) const noexcept {
  const double reach = reach_.at_full_speed(force.vector, force.length, hold.time);
  EnergyNeed by_speed{.first = need.first,
                      .free = hold.free * force.squared,
                      .reach = reach,
                      .linear = reach,
                      .burned = hold.burned * reach * reach,
                      .squared = force.squared};
  if (by_speed.at(1.0) < need.at(1.0)) need = by_speed;
}

}  // namespace feltwire
