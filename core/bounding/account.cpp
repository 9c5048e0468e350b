#include "core/bounding/account.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/numeric.hpp"
#include "core/bounding/lagging_need.hpp"

namespace feltwire {
namespace {

/// Returns the highest integer servo rate [Hz] at which this energy account can model a motor with
/// this lag. Precondition: the lag is not zero.
long highest_rate(const MotorLag& lag) {
  constexpr double kRounded = 1.0 + 1e-9;
  return static_cast<long>(std::floor(kRounded * LaggingForces::kMostSamples / lag.rest()));
}

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
  const double longest = LaggingForces::kMostSamples * config.period;
  if (!(config.lag.time >= 0.0) || !std::isfinite(config.lag.time))
    throw std::invalid_argument("account: the motor lags by " + std::to_string(config.lag.time) +
                                " s; give 0 or more");
  if (config.lag.rest() > longest)
    throw std::invalid_argument(
        "account: the motor lags by up to " + std::to_string(config.lag.time) +
        " s, and its forces may rest for " + std::to_string(config.lag.rest()) + " s; at most " +
        std::to_string(longest) + " s (" + std::to_string(LaggingForces::kMostSamples) +
        " servo periods) can be reckoned with; take a servo rate of at most " +
        std::to_string(highest_rate(config.lag)) +
        " Hz, or measure the device's actuation_lag and give it in a device file (--spec)");
  validate(config.translation, "account, translation");
  validate(config.rotation, "account, rotation");
  return config;
}

/// Returns the largest share s in [0, 1] for which the sum of all needs is at most `balance` [J]. A
/// need is the largest energy that the share s of a force can give to the hand. `Needs` is a span,
/// preferably with a length known at compile time.
template <class Needs>
double affordable(const Needs& needs, double balance) noexcept {
  if (!(balance > 0.0)) return 0.0;
  double most = 0.0, first = 0.0;
  for (const EnergyNeed& need : needs) {
    most += need.most();
    first += need.first;
  }
  if (most <= balance) return 1.0;
  const auto all = [&](double s) {
    double sum = 0.0;
    for (const EnergyNeed& need : needs) sum += need.at(s);
    return sum;
  };
  // A rounding error may raise the sum of a permitted command above the balance. Do not scale such
  // a command.
  if (all(1.0) <= balance * (1.0 + kOffByRounding)) return 1.0;
  // With this factor, a rounding error does not overdraw the balance.
  constexpr double kLess = 1.0 - kOffByRounding;
  const double below = kLess * std::sqrt(balance / first);
  if (std::ranges::all_of(needs, [&](const EnergyNeed& need) { return need.before_turn(below); }))
    return std::min(below, 1.0);
  // At s = `turn`, a need changes from a quadratic function of s to another one (EnergyNeed). Every
  // need grows with s. So the solution is beyond `turn` exactly if the sum of all needs at `turn`
  // is below the balance.
  double square = 0.0, linear = 0.0, left = balance;
  for (const EnergyNeed& need : needs) {
    const double turn = need.reach / need.free;
    const bool beyond = turn < 1.0 && all(turn) < balance;
    square += beyond ? need.second : need.first;
    if (!beyond) continue;
    linear += need.linear;
    left += need.burned / need.squared;
  }
  // Compute the positive root s of square s^2 + linear s = left, in the form without cancellation.
  const double s = 2.0 * left / (linear + std::sqrt(linear * linear + 4.0 * square * left));
  return std::isfinite(s) ? std::clamp(s * kLess, 0.0, 1.0) : 0.0;
}

}  // namespace

PortAccount::PortAccount(const AccountConfig& config)
    : cap_(checked(config).cap),
      looks_ahead_(config.looks_ahead),
      // With a lagging motor, do not learn the force of the hand, because the motor's force is
      // uncertain.
      translation_(config.translation, config.period,
                   config.learns_outside_force && config.lag.time == 0.0),
      rotation_(config.rotation, config.period,
                config.learns_outside_force && config.lag.time == 0.0),
      period_(config.period),
      late_(static_cast<std::size_t>(config.late)),
      older_forces_(config.lag),
      older_torques_(config.lag) {
  coming_forces_.fill(Vec3::Zero());
  coming_torques_.fill(Vec3::Zero());
  translation_.keep_for_late_ticks(config.late);
  rotation_.keep_for_late_ticks(config.late);
  surely_paid_ = 1.0 - std::max(translation_.most_kept(), rotation_.most_kept());
}

/// Adds the energy of the last sample to the balance. Returns the balance [J] that limits the next
/// force: the current balance or, if smaller, the balance expected for the time when this force
/// acts. The expectation assumes that the motion continues.
inline double PortAccount::take_in(const BoundingStep& s) noexcept {
  const bool was_in_debt = in_debt();
  // Reject a movement if its square is not finite, even if its components are finite.
  const double moved = s.displacement.squaredNorm() + s.rotation.squaredNorm();
  const bool known = std::isfinite(moved) && std::isfinite(s.hold_time) && s.hold_time > 0.0;
  const double delivered = held_.force.dot(s.displacement) + held_.torque.dot(s.rotation);
  const double earned =
      known ? translation_.earned(s.displacement, held_.force, s.hold_time, older_forces_) +
                  rotation_.earned(s.rotation, held_.torque, s.hold_time, older_torques_)
            : std::numeric_limits<double>::quiet_NaN();
  if (lags()) {
    older_forces_.passed(held_.force, s.hold_time);
    older_torques_.passed(held_.torque, s.hold_time);
  }
  if (std::isfinite(earned)) {
    balance_ += earned;
    if (translation_.strong_hand() || rotation_.strong_hand()) ++statistics_.strong_hand;
  } else {
    // The movement is unknown, so assume the worst movement. The last force was limited so that
    // even this movement leaves a balance of zero or more.
    balance_ = std::min(balance_, worst_next_);
    translation_.forget();
    rotation_.forget();
  }
  if (balance_ > cap_ && idle()) balance_ = cap_;
  count_debt(was_in_debt);
  if (!std::isfinite(earned) || !looks_ahead_) return balance_;
  const double per_period = delivered * period_ / std::max(period_, s.hold_time);
  const double ahead =
      0.5 + static_cast<double>(late_) + older_forces_.lag().time / period_;  // [samples]
  return balance_ - ahead * std::max(0.0, per_period);
}

/// Returns true if no force acts on the hand and no earlier force is pending.
bool PortAccount::idle() const noexcept {
  for (std::size_t n = 0; n < late_; ++n)
    if (!ForceAndTorque{coming_forces_[n], coming_torques_[n]}.nothing()) return false;
  return held_.nothing() && older_forces_.nothing() && older_torques_.nothing();
}

/// Returns the force and the torque of the last command.
inline PortAccount::Last PortAccount::last() const noexcept {
  if (late_ == 0) return {held_.force, held_.torque};
  return {coming_forces_[late_ - 1], coming_torques_[late_ - 1]};
}

/// Returns the share of the balance that is kept in reserve for a late tick.
inline double PortAccount::kept() const noexcept {
  const double force = translation_.kept_beside(last().force);
  if (force == 0.0) return 0.0;
  const double beside = std::min(force, rotation_.kept_beside(last().torque));
  return beside == PortBalance::kBesideNothing ? 0.0 : beside;
}

/// Returns the share of `wanted` to give. The balance without its reserve is enough for the share
/// `usual`, and the whole balance for the share `most`. The reserve is used only as far as needed
/// to let the force fall gradually.
double PortAccount::softened(const ForceAndTorque& wanted, double usual,
                             double most) const noexcept {
  const bool pushes = !wanted.force.isZero(0.0);
  const double before = pushes ? length(last().force) : length(last().torque);
  const double softer =
      kSoftFall * before / (pushes ? length(wanted.force) : length(wanted.torque));
  return usual >= softer ? usual : std::max(usual, std::min(most, softer));
}

/// Returns the share of `wanted` for which `left` [J] is enough after the pending forces (forces
/// that are given but do not act yet). `own` has the needs of `wanted` after these forces. A force
/// that used all energy would leave none for the next force. So `left` must be enough for `late_` +
/// 1 such forces in a row. Their needs are computed at the returned share. With the needs at a
/// larger share, the result would oscillate.
double PortAccount::share_after_coming(const Needs& own, const ForceAndTorque& wanted, double left,
                                       double hold) noexcept {
  std::array<EnergyNeed, 2 * (std::size_t{AccountConfig::kMostLate} + 1)> all;
  double needed = 0.0;
  for (std::size_t n = 0; n < late_; ++n) {
    needed += need_after({coming_forces_[n], coming_torques_[n]}, n, hold);
    all[2 * n] = translation_.need(wanted.force, hold, {coming_forces_.data(), n});
    all[2 * n + 1] = rotation_.need(wanted.torque, hold, {coming_torques_.data(), n});
    if (n == 0) worst_next_ = std::max(0.0, balance_ - needed);
  }
  std::ranges::copy(own, all.begin() + static_cast<std::ptrdiff_t>(2 * late_));
  const auto share = [&](double balance) {
    return std::min(affordable(own, balance - needed),
                    affordable(std::span(all).first(2 * late_ + 2), balance));
  };
  const double keeps = kept(), usual = share((1.0 - keeps) * left);
  return usual == 1.0 || keeps == 0.0 ? usual : softened(wanted, usual, share(left));
}

/// Returns the need [J] of the whole force and torque `held`, after the first n pending forces.
double PortAccount::need_after(const ForceAndTorque& held, std::size_t n,
                               double hold) const noexcept {
  return translation_.need(held.force, hold, {coming_forces_.data(), n}).at(1.0) +
         rotation_.need(held.torque, hold, {coming_torques_.data(), n}).at(1.0);
}

/// Stores the given force. The force acts on the hand now, or `late_` samples later.
void PortAccount::give(const ForceAndTorque& given) noexcept {
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
  const ForceAndTorque wanted{s.command.force(), s.command.torque};
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

/// Returns the largest share of `wanted` for which `left` [J] is enough. Returns kNoLimit if a need
/// has no limit, for example because a number is not finite.
inline double PortAccount::affordable_share(const ForceAndTorque& wanted, double left,
                                            double hold) noexcept {
  if (lags()) return lagging_share(wanted, left, hold);
  const Needs both{translation_.need(wanted.force, hold, {coming_forces_.data(), late_}),
                   rotation_.need(wanted.torque, hold, {coming_torques_.data(), late_})};
  if (!both[0].limited() || !both[1].limited()) [[unlikely]]
    return kNoLimit;
  if (late_ > 0) return share_after_coming(both, wanted, left, hold);
  if (left > 0.0 && both[0].most() + both[1].most() <= surely_paid_ * left) return 1.0;
  const double keeps = kept(), usual = affordable(both, (1.0 - keeps) * left);
  if (usual == 1.0 || keeps == 0.0) return usual;
  return softened(wanted, usual, affordable(both, left));
}

/// Computes affordable_share() for a lagging motor. The cost of a share has no simple inverse, so
/// this function searches for the share. The needs of the returned share are never above `left`.
double PortAccount::lagging_share(const ForceAndTorque& wanted, double left, double hold) noexcept {
  if (late_ > 0) return lagging_share_after_coming(wanted, left, hold);
  const LaggingNeed force(translation_, older_forces_, wanted.force, hold);
  const LaggingNeed torque(rotation_, older_torques_, wanted.torque, hold);
  if (!force.limited() || !torque.limited()) [[unlikely]]
    return kNoLimit;
  const double share = largest_within(left, [&](double s) { return force.at(s) + torque.at(s); });
  worst_next_ =
      std::max(0.0, balance_ - force.of_first_sample(share) - torque.of_first_sample(share));
  return share;
}

/// Computes lagging_share() for a device that also takes forces up `late_` samples late. The
/// pending forces need energy first, each in the sample in which it is the newest one. As in
/// share_after_coming(), `left` must be enough for `late_` + 1 forces like the returned one.
double PortAccount::lagging_share_after_coming(const ForceAndTorque& wanted, double left,
                                               double hold) noexcept {
  LaggingForces forces = older_forces_, torques = older_torques_;
  double driving = forces.strongest(), turning = torques.strongest();
  for (std::size_t n = 0; n < late_; ++n) {
    driving = std::max(driving, length(coming_forces_[n]));
    turning = std::max(turning, length(coming_torques_[n]));
  }
  double needed = 0.0;
  int late = 0;
  for (std::size_t n = 0; n < late_; ++n, ++late) {
    const LaggingNeed force(translation_, forces, coming_forces_[n], hold, late, driving);
    const LaggingNeed torque(rotation_, torques, coming_torques_[n], hold, late, turning);
    needed += force.of_first_sample(1.0) + torque.of_first_sample(1.0);
    if (n == 0) worst_next_ = std::max(0.0, balance_ - needed);
    forces.passed(coming_forces_[n], hold);
    torques.passed(coming_torques_[n], hold);
  }
  const LaggingNeed force(translation_, forces, wanted.force, hold, late, driving);
  const LaggingNeed torque(rotation_, torques, wanted.torque, hold, late, turning);
  if (!force.limited() || !torque.limited()) [[unlikely]]
    return kNoLimit;
  const auto need = [&](double s) { return force.at(s) + torque.at(s); };
  const auto in_a_row = [&](double s) {
    return need(s) + late * (force.of_first_sample(s) + torque.of_first_sample(s));
  };
  return std::min(largest_within(left - needed, need), largest_within(left, in_a_row));
}

/// Gives the affordable share of each part (force, torque) that has a limited need. Gives nothing
/// if the command is not finite.
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

void PortAccount::go_on_from(const PortAccount& before) noexcept {
  held_ = before.held_;
  coming_forces_ = before.coming_forces_;
  coming_torques_ = before.coming_torques_;
  older_forces_ = before.older_forces_;
  older_torques_ = before.older_torques_;
  worst_next_ = before.worst_next_;
  balance_ = before.balance_;
  statistics_ = before.statistics_;
}

void PortAccount::begin_in_debt(double energy) noexcept {
  held_ = {};
  coming_forces_.fill(Vec3::Zero());
  coming_torques_.fill(Vec3::Zero());
  older_forces_.forget();
  older_torques_.forget();
  worst_next_ = 0.0;
  balance_ = 0.0 - energy;  // This avoids a negative zero.
  translation_.forget();
  rotation_.forget();
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
    if (config.lag.time > 0.0) {
      LaggingForces older(config.lag);
      for (int n = 0; n < LaggingForces::kMostSamples; ++n) older.passed(force, config.period);
      const double strongest = length(force);
      const auto need_of = [&](int late) {
        return LaggingNeed(balance, older, force, config.period, late, strongest);
      };
      double sum = need_of(config.late).at(1.0);
      for (int n = 0; n < config.late; ++n) sum += need_of(n).of_first_sample(1.0);
      return sum;
    }
    const std::vector<Vec3> coming(static_cast<std::size_t>(config.late), force);
    double sum = 0.0;  // [J] sum of the needs after 0, 1, 2, ... forces of `coming`
    for (std::size_t n = 0; n <= coming.size(); ++n)
      sum += balance.need(force, config.period, {coming.data(), n}).at(1.0);
    return sum;
  };
  return need(config.translation, command.force()) + need(config.rotation, command.torque);
}

}  // namespace feltwire
