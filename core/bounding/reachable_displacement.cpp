#include "core/bounding/reachable_displacement.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

void refuse(const char* field, const char* part, double value, const char* remedy) {
  throw std::invalid_argument(std::string(field) + ": " + part + " is " + std::to_string(value) +
                              "; " + remedy);
}

/// Returns the longest time before the end of a sample during which the handle can move along v
/// without a stop or a reversal. The sample lasts `time` [s]. All other values are multiplied by
/// |v|: `driven` and `braked` [m/s^2] are the largest accelerations along v and against v, `way`
/// [m] is the largest movement along v, and `against` [m/s] is the largest initial speed against v.
///
/// With h = `time`, the function solves driven s^2/2 <= way + against (h - s) + braked (h - s)^2/2
/// for s. The left side grows with s, and the right side falls.
double since_turn(double driven, double braked, double way, double against, double time) noexcept {
  const double square = 0.5 * (driven - braked);
  const double linear = against + braked * time;
  const double constant = way + against * time + 0.5 * braked * time * time;
  if (!(constant > 0.0)) return 0.0;
  const double root = linear * linear + 4.0 * square * constant;
  if (!(root >= 0.0)) return time;  // Every s satisfies the inequality.
  const double since = 2.0 * constant / (linear + std::sqrt(root));
  return since < time ? since : time;  // A NaN gives the whole time.
}

}  // namespace

void validate(const PortKnowledge& port, const char* field) {
  validate(port.damping, field);
  const auto lower_bound = [&](const char* part, double value, const char* remedy) {
    if (!(value >= 0.0) || !std::isfinite(value)) refuse(field, part, value, remedy);
  };
  lower_bound("the Coulomb friction", port.coulomb_friction,
              "give a lower bound in N (N m), 0 when none is known");
  lower_bound("the encoder quantum", port.quantum, "give it in m (rad), 0 for an exact sensor");
  lower_bound("the mass", port.mass, "give a lower bound in kg (kg m^2), 0 when none is known");
  if (!(port.outside_force >= 0.0))  // Infinity means unknown.
    refuse(field, "the outside force", port.outside_force,
           "give an upper bound in N (N m), infinity when none is known");
  if (!(port.speed > 0.0))  // Infinity means unknown.
    refuse(field, "the speed", port.speed,
           "give an upper bound in m/s (rad/s) above 0, infinity when none is known");
}

double ReachableDisplacement::Past::magnitude() const noexcept {
  return joined ? strongest : length(held);
}

/// Joins two samples. Assumes that the stronger force acted all the time, in any direction.
ReachableDisplacement::Past ReachableDisplacement::together(const Past& first,
                                                            const Past& second) noexcept {
  return {.displacement = first.displacement + second.displacement,
          .held = second.held,
          .time = first.time + second.time,
          .strongest = std::max(first.magnitude(), second.magnitude()),
          .joined = true};
}

void ReachableDisplacement::moved(const Vec3& displacement, const Vec3& held, double hold_time,
                                  double period, double strongest) noexcept {
  period_ = period;
  // After an unknown movement, the speed stays unknown until one whole sample determines it.
  const bool too_short = hold_time < 0.5 * period;
  Past sample{.displacement = displacement, .held = held, .time = hold_time};
  if (strongest >= 0.0) {
    sample.strongest = std::max(strongest, length(held));
    sample.joined = true;
  }
  if (too_short && last().time > 0.0 && last().time < 0.5 * period) {
    past_[newest_] = together(last(), sample);
    return;
  }
  newest_ = newest_ + 1 < past_.size() ? newest_ + 1 : 0;
  past_[newest_] = sample;
}

/// Returns |v| times the largest speed along v at the end of `sample`. `before` is the age (in
/// samples) of the sample before it.
double ReachableDisplacement::fastest(const Past& sample, std::size_t before, const Vec3& v,
                                      double length) const noexcept {
  const double outside = known_.outside_force * length;
  const double driven = per_mass_ * (sample.along(v, length) + outside);
  const double way = sample.displacement.dot(v) + known_.quantum * v.lpNorm<1>();
  double since = sample.time;
  if (before < past_.size() && past(before).time > 0.0) {
    const double held = sample.joined ? -sample.strongest * length : sample.held.dot(v);
    const double braked = std::max(0.0, per_mass_ * (outside - held));
    const double against = fastest(past(before), before + 1, -v, length);
    since = since_turn(std::max(0.0, driven), braked, way, against, sample.time);
  }
  return std::max({0.0, driven * since, way / sample.time + 0.5 * driven * sample.time});
}

/// Returns |v| times the largest speed along v after a sample of irregular duration. `simple` is
/// the bound from this sample alone. The result is never below the bound after a regular period
/// with the same speed. So irregular ticks do not reduce the reachable displacement of a handle at
/// rest.
double ReachableDisplacement::irregular(const Vec3& v, double length,
                                        double simple) const noexcept {
  const Past& before = last();
  const double driven =
      per_mass_ * (before.along(v, length) + known_.outside_force * length) * period_;
  const double speed =
      before.displacement.dot(v) / before.time + known_.quantum * v.lpNorm<1>() / period_;
  const double least = std::max({0.0, driven, speed + 0.5 * driven});
  const bool usual = std::abs(before.time - period_) <= kUsual * period_;
  if (simple <= least || usual) return std::max(least, simple);
  double most = std::min(simple, fastest(before, 1, v, length));
  if (before.time < period_ && past(1).time > 0.0)
    most = std::min(most, fastest(together(past(1), before), 2, v, length));
  return std::max(least, most);
}

}  // namespace feltwire
