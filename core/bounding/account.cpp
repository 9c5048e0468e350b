#include "core/bounding/account.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kOffByRounding = 1e-12;  // more than the arithmetic of a step rounds off

const AccountConfig& checked(const AccountConfig& config) {
  if (!(config.period > 0.0) || !std::isfinite(config.period))
    throw std::invalid_argument("account: the period is " + std::to_string(config.period) +
                                " s; give the servo period, above 0");
  if (!(config.cap >= 0.0))
    throw std::invalid_argument("account: the cap is " + std::to_string(config.cap) +
                                " J; give an energy of 0 or more, infinity for no cap");
  if (config.late < 0 || config.late > AccountConfig::kMostLate)
    throw std::invalid_argument("account: forces are taken up " + std::to_string(config.late) +
                                " samples late; give 0 to " +
                                std::to_string(AccountConfig::kMostLate));
  validate(config.translation, "account, translation");
  validate(config.rotation, "account, rotation");
  return config;
}

/// The largest share s of 0 to 1 that `balance` pays for: force.at(s) + torque.at(s) <= balance.
double affordable(const EnergyNeed& force, const EnergyNeed& torque, double balance) noexcept {
  if (!(balance > 0.0)) return 0.0;
  if (force.most() + torque.most() <= balance) return 1.0;
  const auto both = [&](double s) { return force.at(s) + torque.at(s); };
  // A command at its own bound's limit is off by some roundings: it is not scaled for that.
  if (both(1.0) <= balance * (1.0 + kOffByRounding)) return 1.0;
  constexpr double kLess = 1.0 - kOffByRounding;  // rounding must not overdraw
  const double below = kLess * std::sqrt(balance / (force.first + torque.first));
  if (force.before_turn(below) && torque.before_turn(below)) return std::min(below, 1.0);
  // Both grow with s, so the answer lies beyond a turn exactly when the turn costs less.
  double square = 0.0, linear = 0.0, left = balance;
  for (const EnergyNeed* need : {&force, &torque}) {
    const double turn = need->reach / need->free;
    const bool beyond = turn < 1.0 && both(turn) < balance;
    square += beyond ? need->second : need->first;
    if (!beyond) continue;
    linear += need->linear;
    left += need->burned / need->squared;
  }
  // The positive root of square s^2 + linear s = left, without cancellation.
  const double s = 2.0 * left / (linear + std::sqrt(linear * linear + 4.0 * square * left));
  return std::isfinite(s) ? std::clamp(s * kLess, 0.0, 1.0) : 0.0;
}

}  // namespace

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

double PortBalance::damping_along(const Vec3& force) const noexcept {
  if (known_.damping.isotropic()) return known_.damping.matrix()(0, 0);
  // If a direction is not damped at all, a force along any other may move the handle along it.
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
  // A movement of one quantum is always within reach, and often exactly as far as that.
  return squared >
         (1.0 + kOffByRounding) * reach_.along(displacement, std::sqrt(squared), held, hold_time);
}

double PortBalance::earned(const Vec3& displacement, const Vec3& held, double hold_time) noexcept {
  if (limits_speed_) {
    const double squared = displacement.squaredNorm();
    too_fast_ = squared > reach_.at_full_speed(displacement, std::sqrt(squared), hold_time);
  }
  if (reach_.bounds() || limits_speed_) {
    const bool too_far = beyond_reach(displacement, held, hold_time);
    strong_hand_ = too_far || too_fast_;
    if (learned_) {
      learned_->moved(displacement, held, hold_time);
      if (too_far) learned_->exceeded();
      reach_.set_outside_force(learned_->bound());
    }
    reach_.moved(displacement, held, hold_time, period_);
  }
  const double rubbed =
      known_.coulomb_friction > 0.0 ? known_.coulomb_friction * path_.moved(displacement) : 0.0;
  return known_.damping.quadratic(displacement) / std::max(period_, hold_time) + rubbed -
         held.dot(displacement);
}

// max of F y - (b/h) y^2 over 0 <= y <= d(F) = d0 + k F, with F = s |wanted|: the free maximum
// F^2 h/(4b) at y = F h/(2b) while that is within reach, and the value at d(F) beyond.
inline void PortBalance::limit_by_inertia(EnergyNeed& need, const Force& force, const Hold& hold,
                                          std::span<const Vec3> coming) const noexcept {
  const double k = hold.per_newton;
  if (!(k < hold.free)) return;  // so well damped that no force moves the handle that far
  need.reach = reach_.along(force.vector, force.length, hold.time) +
               reach_.driven(force.vector, force.length, coming, hold.time);
  need.free = (hold.free - k) * force.squared;
  need.second = hold.second * force.squared;
  need.linear = hold.linear * need.reach;
  need.burned = hold.burned * need.reach * need.reach;
  need.squared = force.squared;
}

EnergyNeed PortBalance::need(const Vec3& wanted, double hold_time,
                             std::span<const Vec3> coming) const noexcept {
  EnergyNeed need;
  const double squared = wanted.squaredNorm();
  if (squared == 0.0) return need;
  const Force force{wanted, squared, std::sqrt(squared)};
  const bool prepared = !directional_ && hold_.time == hold_time;
  const Hold other = prepared ? Hold{} : hold_of(damping_along(wanted), hold_time);
  const Hold& hold = prepared ? hold_ : other;
  need.first = 0.5 * hold.free * squared;
  if (reach_.known()) limit_by_inertia(need, force, hold, coming);
  // A handle that was just faster than was told may be so again.
  if (limits_speed_ && !too_fast_) limit_by_speed(need, force, hold);
  return need;
}

double PortBalance::need_of_any_hand(const Vec3& wanted, double hold_time) const noexcept {
  const double squared = wanted.squaredNorm();
  if (squared == 0.0) return 0.0;
  return 0.5 * hold_of(damping_along(wanted), hold_time).free * squared;
}

/// Both limits are true at every share of the force, so the one that is less at the whole of it is
/// taken; the maximum within both at once would be a little less still.
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

PortAccount::PortAccount(const AccountConfig& config)
    : cap_(checked(config).cap),
      looks_ahead_(config.looks_ahead),
      translation_(config.translation, config.period, config.learns_outside_force),
      rotation_(config.rotation, config.period, config.learns_outside_force),
      period_(config.period),
      late_(static_cast<std::size_t>(config.late)) {
  coming_forces_.fill(Vec3::Zero());
  coming_torques_.fill(Vec3::Zero());
}

/// Returns the balance that the next force is cut to: the present one, or the one half a sample
/// ahead if the motion goes on, whichever is less.
inline double PortAccount::take_in(const BoundingStep& s) noexcept {
  const bool was_in_debt = in_debt();
  // A movement whose square is not finite is not usable, even where its numbers are.
  const double moved = s.displacement.squaredNorm() + s.rotation.squaredNorm();
  const bool known = std::isfinite(moved) && std::isfinite(s.hold_time) && s.hold_time > 0.0;
  const double delivered = held_.force.dot(s.displacement) + held_.torque.dot(s.rotation);
  const double earned = known ? translation_.earned(s.displacement, held_.force, s.hold_time) +
                                    rotation_.earned(s.rotation, held_.torque, s.hold_time)
                              : std::numeric_limits<double>::quiet_NaN();
  if (std::isfinite(earned)) {
    balance_ += earned;
    if (translation_.strong_hand() || rotation_.strong_hand()) ++statistics_.strong_hand;
  } else {
    // The last force was affordable, so the worst movement left a balance that is not negative.
    balance_ = std::min(balance_, worst_next_);
    translation_.forget();
    rotation_.forget();
  }
  if (balance_ > cap_ && idle()) balance_ = cap_;
  count_debt(was_in_debt);
  if (!std::isfinite(earned) || !looks_ahead_) return balance_;
  const double per_period = delivered * period_ / std::max(period_, s.hold_time);
  const double ahead = 0.5 + static_cast<double>(late_);  // [samples]
  return balance_ - ahead * std::max(0.0, per_period);
}

/// Nothing is on the hand, and nothing will be that was given before.
bool PortAccount::idle() const noexcept {
  for (std::size_t n = 0; n < late_; ++n)
    if (!Held{coming_forces_[n], coming_torques_[n]}.nothing()) return false;
  return held_.nothing();
}

/// Of `left` [J], the part that the coming forces leave for `wanted`, which needs `last` [J] after
/// them. A force that took all of it would leave nothing for the next one, which would leave all
/// for the one after it. So it also gets no more than its share of what it needs at each of L + 1
/// samples.
double PortAccount::left_after_coming(double left, const Held& wanted, double last,
                                      double hold) noexcept {
  double needed = 0.0, each = last;
  for (std::size_t n = 0; n < late_; ++n) {
    needed += need_after({coming_forces_[n], coming_torques_[n]}, n, hold);
    each += need_after(wanted, n, hold);
    if (n == 0) worst_next_ = std::max(0.0, balance_ - needed);
  }
  const double share = last > 0.0 ? last / each : 1.0;
  return std::min(left - needed, share * left);
}

/// [J] of the whole of `held`, after the first n of the coming ones.
double PortAccount::need_after(const Held& held, std::size_t n, double hold) const noexcept {
  return translation_.need(held.force, hold, {coming_forces_.data(), n}).at(1.0) +
         rotation_.need(held.torque, hold, {coming_torques_.data(), n}).at(1.0);
}

/// Takes note of what was given: it is on the hand now, or L samples later.
void PortAccount::give(const Held& given) noexcept {
  if (late_ == 0) {
    held_ = given;
    return;
  }
  held_ = {coming_forces_.front(), coming_torques_.front()};
  const auto end = static_cast<std::ptrdiff_t>(late_);
  std::shift_left(coming_forces_.begin(), coming_forces_.begin() + end, 1);
  std::shift_left(coming_torques_.begin(), coming_torques_.begin() + end, 1);
  coming_forces_[late_ - 1] = given.force;
  coming_torques_[late_ - 1] = given.torque;
}

Command PortAccount::step(const BoundingStep& s, double next_hold) noexcept {
  const double left = take_in(s), hold = std::max(period_, next_hold);
  translation_.prepare(hold);
  rotation_.prepare(hold);
  const Held wanted{s.command.force(), s.command.torque};
  const double share = affordable_share(wanted, left, hold);
  if (share == 1.0) {
    give(wanted);
    return s.command;
  }
  if (share == kNoLimit) [[unlikely]]
    return give_limited_part(s.command, left, hold);
  Command given = share * s.command;
  give({given.force(), given.torque});
  if (!wanted.nothing()) ++statistics_.reduced;
  return given;
}

/// The largest share of `wanted` that `left` [J] pays for. kNoLimit where a need has no limit, as
/// that of a number that is not finite.
inline double PortAccount::affordable_share(const Held& wanted, double left, double hold) noexcept {
  const EnergyNeed force = translation_.need(wanted.force, hold, {coming_forces_.data(), late_});
  const EnergyNeed torque = rotation_.need(wanted.torque, hold, {coming_torques_.data(), late_});
  if (!force.limited() || !torque.limited()) [[unlikely]]
    return kNoLimit;
  if (late_ > 0) left = left_after_coming(left, wanted, force.at(1.0) + torque.at(1.0), hold);
  return affordable(force, torque, left);
}

/// Gives what is affordable of the parts whose need has a limit, and nothing of a command that is
/// not finite.
Command PortAccount::give_limited_part(const Command& command, double left, double hold) noexcept {
  Command given;
  if (command.finite()) {
    if (translation_.need(command.force(), hold).limited()) {
      given.elastic = command.elastic;
      given.frictional = command.frictional;
    }
    if (rotation_.need(command.torque, hold).limited()) given.torque = command.torque;
    given = affordable_share({given.force(), given.torque}, left, hold) * given;
    if (given != command) ++statistics_.reduced;
  }
  give({given.force(), given.torque});
  return given;
}

void PortAccount::count_debt(bool was_in_debt) noexcept {
  if (!in_debt()) return;
  if (!was_in_debt) ++statistics_.overdrawn;
  statistics_.largest_debt = std::max(statistics_.largest_debt, -balance_);
}

double need_at_rest(const AccountConfig& config, const Command& command) {
  checked(config);
  const auto need = [&](const PortKnowledge& known, const Vec3& force) {
    PortBalance balance(known, config.period);
    balance.earned(Vec3::Zero(), force, config.period);
    const std::vector<Vec3> coming(static_cast<std::size_t>(config.late), force);
    double sum = 0.0;  // of the samples of which this force needs the energy together
    for (std::size_t n = 0; n <= coming.size(); ++n)
      sum += balance.need(force, config.period, {coming.data(), n}).at(1.0);
    return sum;
  };
  return need(config.translation, command.force()) + need(config.rotation, command.torque);
}

}  // namespace feltwire
