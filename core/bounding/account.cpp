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
  const auto both = [&](double s) { return force.at(s) + torque.at(s); };
  // A command at its own bound's limit is off by some roundings: it is not scaled for that.
  constexpr double kRounding = 1e-12;
  if (both(1.0) <= balance * (1.0 + kRounding)) return 1.0;
  // Both grow with s, so the answer lies beyond a turn exactly when the turn costs less.
  double square = 0.0, linear = 0.0, constant = 0.0;
  for (const EnergyNeed* need : {&force, &torque}) {
    const bool beyond = need->turn < 1.0 && both(need->turn) < balance;
    square += beyond ? need->second : need->first;
    if (!beyond) continue;
    linear += need->linear;
    constant += need->constant;
  }
  // The positive root of square s^2 + linear s = left, without cancellation.
  const double left = balance - constant;
  const double s = 2.0 * left / (linear + std::sqrt(linear * linear + 4.0 * square * left));
  // Rounding must not overdraw.
  return std::isfinite(s) ? std::clamp(s * (1.0 - kRounding), 0.0, 1.0) : 0.0;
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

double PortBalance::damping_along(const Vec3& unit) const noexcept {
  if (known_.damping.isotropic()) return known_.damping.matrix()(0, 0);
  // If a direction is not damped at all, a force along any other may move the handle along it.
  return directional_ ? 1.0 / unit.dot(inverse_damping_ * unit) : 0.0;
}

void PortBalance::forget() noexcept {
  reach_.forget();
  path_.forget();
  if (learned_) learned_->forget();
  strong_hand_ = false;
  too_fast_ = false;
}

PortBalance::Hold PortBalance::hold_of(double damping, double hold_time) const noexcept {
  return {
      .time = hold_time,
      .free = damping > 0.0 ? hold_time / (2.0 * damping) : std::numeric_limits<double>::infinity(),
      .burned = damping / hold_time,
      .per_newton = reach_.per_newton(hold_time)};
}

void PortBalance::prepare(double hold_time) noexcept {
  if (directional_ || hold_.time == hold_time) return;
  const bool same_everywhere = known_.damping.isotropic();
  hold_ = hold_of(same_everywhere ? known_.damping.matrix()(0, 0) : 0.0, hold_time);
}

bool PortBalance::beyond_reach(const Vec3& displacement, const Vec3& held,
                               double hold_time) const noexcept {
  if (!reach_.known() || reach_.goes_on(displacement, hold_time)) return false;
  const Polar<double> way = polar(displacement);
  return way.length > 0.0 &&
         way.length > reach_.along(way.direction, held.dot(way.direction), hold_time);
}

double PortBalance::earned(const Vec3& displacement, const Vec3& held, double hold_time) noexcept {
  if (limits_speed_) {
    const Polar<double> way = polar(displacement);
    too_fast_ = way.length > reach_.at_full_speed(way.direction, hold_time);
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
EnergyNeed PortBalance::need(const Vec3& wanted, double hold_time,
                             std::span<const Vec3> coming) const noexcept {
  const Polar<double> force = polar(wanted);
  EnergyNeed need;
  if (!(force.length > 0.0)) return need;
  const bool prepared = !directional_ && hold_.time == hold_time;
  const Hold hold = prepared ? hold_ : hold_of(damping_along(force.direction), hold_time);
  need.first = 0.5 * hold.free * force.length * force.length;
  if (reach_.known()) limit_by_inertia(need, force, hold, coming);
  // A handle that was just faster than was told may be so again.
  if (limits_speed_ && !too_fast_) limit_by_speed(need, force, hold);
  return need;
}

double PortBalance::need_of_any_hand(const Vec3& wanted, double hold_time) const noexcept {
  const Polar<double> force = polar(wanted);
  if (!(force.length > 0.0)) return 0.0;
  const Hold hold = hold_of(damping_along(force.direction), hold_time);
  return 0.5 * hold.free * force.length * force.length;
}

void PortBalance::limit_by_inertia(EnergyNeed& need, const Polar<double>& force, const Hold& hold,
                                   std::span<const Vec3> coming) const noexcept {
  const double f = force.length, k = hold.per_newton;
  if (!(k < hold.free)) return;  // so well damped that no force moves the handle that far
  const double d0 =
      reach_.along(force.direction, hold.time) + reach_.driven(force.direction, coming, hold.time);
  need.turn =
      hold.free < std::numeric_limits<double>::infinity() ? d0 / ((hold.free - k) * f) : 0.0;
  need.second = k * f * f * (1.0 - hold.burned * k);
  need.linear = f * d0 * (1.0 - 2.0 * hold.burned * k);
  need.constant = -hold.burned * d0 * d0;
}

/// Both limits are true at every share of the force, so the one that is less at the whole of it is
/// taken; the maximum within both at once would be a little less still.
void PortBalance::limit_by_speed(EnergyNeed& need, const Polar<double>& force,
                                 const Hold& hold) const noexcept {
  const double way = reach_.at_full_speed(force.direction, hold.time);
  EnergyNeed by_speed{.first = need.first,
                      .turn = 2.0 * hold.burned * way / force.length,
                      .linear = force.length * way,
                      .constant = -hold.burned * way * way};
  if (by_speed.at(1.0) < need.at(1.0)) need = by_speed;
}

PortAccount::PortAccount(const AccountConfig& config)
    : cap_(checked(config).cap),
      looks_ahead_(config.looks_ahead),
      translation_(config.translation, config.period, config.learns_outside_force),
      rotation_(config.rotation, config.period, config.learns_outside_force),
      period_(config.period),
      late_(static_cast<std::size_t>(config.late)) {}

/// Returns the balance that the next force is cut to: the present one, or the one half a sample
/// ahead if the motion goes on, whichever is less.
double PortAccount::take_in(const BoundingStep& s) noexcept {
  const bool was_in_debt = in_debt();
  const bool known = s.displacement.allFinite() && s.rotation.allFinite() &&
                     std::isfinite(s.hold_time) && s.hold_time > 0.0;
  const Vec3 force = held_.force();
  const double delivered = force.dot(s.displacement) + held_.torque.dot(s.rotation);
  const double earned = known ? translation_.earned(s.displacement, force, s.hold_time) +
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
  const auto nothing = [](const Command& c) {
    return c.force().isZero(0.0) && c.torque.isZero(0.0);
  };
  return nothing(held_) &&
         std::all_of(coming_.begin(), coming_.begin() + static_cast<std::ptrdiff_t>(late_),
                     nothing);
}

/// Of `left` [J], the part that the coming forces leave for `wanted`, which needs `last` [J] after
/// them. A force that took all of it would leave nothing for the next one, which would leave all
/// for the one after it. So it also gets no more than its share of what it needs at each of L + 1
/// samples.
double PortAccount::left_after_coming(double left, const Command& wanted, double last,
                                      double hold) noexcept {
  double needed = 0.0, each = last;
  for (std::size_t n = 0; n < late_; ++n) {
    needed += need_after(coming_[n], n, hold);
    each += need_after(wanted, n, hold);
    if (n == 0) worst_next_ = std::max(0.0, balance_ - needed);
  }
  const double share = last > 0.0 ? last / each : 1.0;
  return std::min(left - needed, share * left);
}

/// [J] of the whole of `command`, held after the first n of the coming ones.
double PortAccount::need_after(const Command& command, std::size_t n, double hold) const noexcept {
  return translation_.need(command.force(), hold, {coming_forces_.data(), n}).at(1.0) +
         rotation_.need(command.torque, hold, {coming_torques_.data(), n}).at(1.0);
}

/// Takes note of the given force: it is on the hand now, or L samples later.
void PortAccount::give(const Command& given) noexcept {
  held_ = late_ > 0 ? coming_.front() : given;
  if (late_ == 0) return;
  std::shift_left(coming_.begin(), coming_.begin() + static_cast<std::ptrdiff_t>(late_), 1);
  coming_[late_ - 1] = given;
  for (std::size_t n = 0; n < late_; ++n) {
    coming_forces_[n] = coming_[n].force();
    coming_torques_[n] = coming_[n].torque;
  }
}

Command PortAccount::step(const BoundingStep& s, double next_hold) noexcept {
  const double left = take_in(s);
  Command given =
      afforded(s.command.finite() ? s.command : Command{}, left, std::max(period_, next_hold));
  give(given);
  return given;
}

void PortAccount::count_debt(bool was_in_debt) noexcept {
  if (!in_debt()) return;
  if (!was_in_debt) ++statistics_.overdrawn;
  statistics_.largest_debt = std::max(statistics_.largest_debt, -balance_);
}

/// The part of `command` that `left` [J] pays for.
Command PortAccount::afforded(const Command& command, double left, double hold) noexcept {
  translation_.prepare(hold);
  rotation_.prepare(hold);
  Command wanted = command;
  EnergyNeed force = translation_.need(wanted.force(), hold, {coming_forces_.data(), late_});
  EnergyNeed torque = rotation_.need(wanted.torque, hold, {coming_torques_.data(), late_});
  const bool all_limited = force.limited() && torque.limited();
  if (!force.limited()) {
    wanted.elastic.setZero();
    wanted.frictional.setZero();
    force = {};
  }
  if (!torque.limited()) {
    wanted.torque.setZero();
    torque = {};
  }
  if (late_ > 0) left = left_after_coming(left, wanted, force.at(1.0) + torque.at(1.0), hold);
  const double share = affordable(force, torque, left);
  if (share < 1.0) wanted = share * wanted;
  if ((share < 1.0 || !all_limited) && wanted != command) ++statistics_.reduced;
  return wanted;
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
