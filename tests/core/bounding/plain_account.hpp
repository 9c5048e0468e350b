#pragma once
// The account's arithmetic written out step by step, by lengths and directions: it stores and
// skips nothing. The product's account is quicker, multiplies where this one divides, and must
// give the same up to rounding (account_plain_test.cpp).

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/numeric.hpp"
#include "core/bounding/account.hpp"

namespace feltwire::test {

constexpr double kRounding = 1e-12;

/// EnergyNeed in the form of docs/bounding.md.
struct PlainNeed {
  double first = 0.0, turn = std::numeric_limits<double>::infinity();
  double second = 0.0, linear = 0.0, constant = 0.0;
  bool limited() const {
    return first < std::numeric_limits<double>::infinity() ||
           turn < std::numeric_limits<double>::infinity();
  }
  double at(double s) const {
    return s < turn ? first * s * s : (second * s + linear) * s + constant;
  }
};

/// A port of the account: what a sample earns, and what the next one can take.
class PlainPort {
 public:
  PlainPort(const PortKnowledge& known, double period, bool learns)
      : known_(known), period_(period), path_(known.quantum) {
    if (learns && bounds()) learned_.emplace(known, period);
  }

  bool strong_hand() const { return strong_; }

  void forget() {
    past_ = {};
    path_.forget();
    if (learned_) learned_->forget();
    strong_ = too_fast_ = false;
  }

  double earned(const Vec3& dx, const Vec3& held, double hold) {
    const Polar<double> way = polar(dx);
    too_fast_ = limits_speed() && way.length > at_full_speed(way.direction, hold);
    const bool too_far =
        bounds() && past_[0].time > 0.0 && way.length > 0.0 &&
        way.length > (1.0 + kRounding) * reach(way.direction, held.dot(way.direction), hold);
    strong_ = too_far || too_fast_;
    if (learned_) {
      learned_->moved(dx, held, hold);
      if (too_far) learned_->exceeded();
      known_.outside_force = learned_->bound();
    }
    moved(dx, held, hold);
    return known_.damping.quadratic(dx) / std::max(period_, hold) +
           known_.coulomb_friction * path_.moved(dx) - held.dot(dx);
  }

  PlainNeed need(const Vec3& wanted, double hold) const {
    const Polar<double> force = polar(wanted);
    const double f = force.length;
    PlainNeed need;
    if (!(f > 0.0)) return need;
    const double b = damping_along(force.direction);
    need.first = b > 0.0 ? 0.5 * (hold / (2.0 * b)) * f * f : kInfinity;
    const double free = b > 0.0 ? hold / (2.0 * b) : kInfinity;
    const double k = hold * hold / (2.0 * known_.mass);
    const double burned = b / hold;
    if (bounds() && past_[0].time > 0.0 && k < free) {
      const double d0 = reach(force.direction, 0.0, hold);
      need.turn = std::isfinite(free) ? d0 / ((free - k) * f) : 0.0;
      need.second = k * f * f * (1.0 - burned * k);
      need.linear = f * d0 * (1.0 - 2.0 * burned * k);
      need.constant = -burned * d0 * d0;
    }
    if (!limits_speed() || too_fast_) return need;
    const double way = at_full_speed(force.direction, hold);
    const PlainNeed by_speed{.first = need.first,
                             .turn = 2.0 * burned * way / f,
                             .linear = f * way,
                             .constant = -burned * way * way};
    return by_speed.at(1.0) < need.at(1.0) ? by_speed : need;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  bool bounds() const { return known_.mass > 0.0 && known_.outside_force < kInfinity; }
  bool limits_speed() const { return known_.speed < kInfinity; }
  double at_full_speed(const Vec3& u, double hold) const {
    return known_.speed * hold + known_.quantum * u.lpNorm<1>();
  }
  double damping_along(const Vec3& u) const {
    const Mat3& b = known_.damping.matrix();
    if (known_.damping.isotropic()) return b(0, 0);
    return known_.damping.least() > 0.0 ? 1.0 / u.dot(b.inverse() * u) : 0.0;
  }
  /// A sample that shows a speed.
  struct Past {
    Vec3 dx = Vec3::Zero(), held = Vec3::Zero();
    double time = 0.0, strongest = 0.0;
    bool joined = false;
  };
  static Past together(const Past& first, const Past& second) {
    const auto most = [](const Past& p) { return p.joined ? p.strongest : length(p.held); };
    return {first.dx + second.dx, Vec3::Zero(), first.time + second.time,
            std::max(most(first), most(second)), true};
  }
  double driven(const Past& p, const Vec3& u) const {
    return ((p.joined ? p.strongest : p.held.dot(u)) + known_.outside_force) / known_.mass;
  }

  double reach(const Vec3& u, double force, double hold) const {
    const double during = std::max(0.0, force + known_.outside_force) / known_.mass;
    return speed(u) * hold + 0.5 * during * hold * hold + known_.quantum * u.lpNorm<1>();
  }
  /// The largest speed along u at the end of the last sample.
  double speed(const Vec3& u) const {
    const Past& last = past_[0];
    const double g = driven(last, u), quantum = known_.quantum * u.lpNorm<1>();
    const double simple = std::max(
        {0.0, g * last.time, (last.dx.dot(u) + quantum) / last.time + 0.5 * g * last.time});
    const double late = std::abs(last.time - period_);
    if (late <= 1e-9 * period_) return simple;
    const double least = std::max(
        {0.0, g * period_, last.dx.dot(u) / last.time + quantum / period_ + 0.5 * g * period_});
    if (simple <= least || late <= 0.02 * period_) return std::max(simple, least);
    double most = std::min(simple, speed_after(last, 1, u));
    if (last.time < period_ && past_[1].time > 0.0)
      most = std::min(most, speed_after(together(past_[1], last), 2, u));
    return std::max(least, most);
  }
  /// The largest speed along u at the end of `p`. past_[before] is the sample before `p`.
  double speed_after(const Past& p, std::size_t before, const Vec3& u) const {
    const double g = driven(p, u), way = p.dx.dot(u) + known_.quantum * u.lpNorm<1>();
    double since = p.time;
    if (before < past_.size() && past_[before].time > 0.0) {
      const double braked = std::max(0.0, driven(p, -u));
      const double against = speed_after(past_[before], before + 1, -u);
      // Whether a drive along u for `s` moves the handle farther than it can have moved.
      const auto too_long = [&](double s) {
        const double left = p.time - s;
        return 0.5 * std::max(0.0, g) * s * s > way + against * left + 0.5 * braked * left * left;
      };
      double low = 0.0, high = p.time;
      for (int i = 0; i < 60 && too_long(p.time); ++i)
        (too_long(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
      since = high;
    }
    return std::max({0.0, g * since, way / p.time + 0.5 * g * p.time});
  }
  void moved(const Vec3& dx, const Vec3& held, double hold) {
    const Past now{dx, held, hold};
    if (hold < 0.5 * period_ && past_[0].time > 0.0 && past_[0].time < 0.5 * period_) {
      past_[0] = together(past_[0], now);
    } else {
      past_ = {now, past_[0], past_[1]};
    }
  }

  PortKnowledge known_;
  double period_;
  PathLowerBound path_;
  std::optional<HandForceBound> learned_;
  std::array<Past, 3> past_;  // newest first
  bool too_fast_ = false, strong_ = false;
};

/// The largest share s <= 1 of the command with force.at(s) + torque.at(s) <= left.
inline double plain_share(const PlainNeed& force, const PlainNeed& torque, double left) {
  if (!(left > 0.0)) return 0.0;
  const auto both = [&](double s) { return force.at(s) + torque.at(s); };
  if (both(1.0) <= left * (1.0 + kRounding)) return 1.0;
  double square = 0.0, linear = 0.0, constant = 0.0;
  for (const PlainNeed* need : {&force, &torque}) {
    const bool beyond = need->turn < 1.0 && both(need->turn) < left;
    square += beyond ? need->second : need->first;
    linear += beyond ? need->linear : 0.0;
    constant += beyond ? need->constant : 0.0;
  }
  const double rest = left - constant;
  const double s = 2.0 * rest / (linear + std::sqrt(linear * linear + 4.0 * square * rest));
  return std::isfinite(s) ? std::clamp(s * (1.0 - kRounding), 0.0, 1.0) : 0.0;
}

class PlainAccount {
 public:
  explicit PlainAccount(const AccountConfig& c)
      : config_(c),
        translation_(c.translation, c.period, c.learns_outside_force),
        rotation_(c.rotation, c.period, c.learns_outside_force) {}

  Command step(const BoundingStep& s, double next_hold) {
    const double left = take_in(s);
    held_ = {};
    if (!s.command.finite()) return held_;
    Command wanted = s.command;
    const double hold = std::max(config_.period, next_hold);
    PlainNeed force = translation_.need(wanted.force(), hold);
    PlainNeed torque = rotation_.need(wanted.torque, hold);
    if (!force.limited()) wanted.elastic = wanted.frictional = Vec3::Zero();
    if (!force.limited()) force = {};
    if (!torque.limited()) wanted.torque.setZero();
    if (!torque.limited()) torque = {};
    const double share = plain_share(force, torque, left);
    held_ = share < 1.0 ? share * wanted : wanted;
    reduced += held_ != s.command;
    return held_;
  }
  void set_held(const Command& held) { held_ = held; }
  double balance() const { return balance_; }

  std::uint64_t reduced = 0, strong_hand = 0;

 private:
  double take_in(const BoundingStep& s) {
    const bool known = s.displacement.allFinite() && s.rotation.allFinite() &&
                       std::isfinite(s.hold_time) && s.hold_time > 0.0;
    const double delivered = held_.force().dot(s.displacement) + held_.torque.dot(s.rotation);
    const double earned = known ? translation_.earned(s.displacement, held_.force(), s.hold_time) +
                                      rotation_.earned(s.rotation, held_.torque, s.hold_time)
                                : std::numeric_limits<double>::quiet_NaN();
    if (std::isfinite(earned)) {
      balance_ += earned;
      strong_hand += translation_.strong_hand() || rotation_.strong_hand();
    } else {
      balance_ = std::min(balance_, 0.0);
      translation_.forget();
      rotation_.forget();
    }
    if (held_.force().isZero(0.0) && held_.torque.isZero(0.0))
      balance_ = std::min(balance_, config_.cap);
    if (!std::isfinite(earned) || !config_.looks_ahead) return balance_;
    const double per_period = delivered * config_.period / std::max(config_.period, s.hold_time);
    return balance_ - 0.5 * std::max(0.0, per_period);
  }

  AccountConfig config_;
  PlainPort translation_, rotation_;
  Command held_;
  double balance_ = 0.0;
};

}  // namespace feltwire::test
