// A motor follows its commands with a lag. The true force must give the hand no more energy than
// the device dissipated, for all hands and commands.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <deque>
#include <numbers>
#include <random>

#include "core/bounding/device_account.hpp"
#include "core/bounding/lagging_need.hpp"
#include "tests/core/bounding/account_samples.hpp"

namespace feltwire::account_lag_test {
namespace {

using namespace test;

constexpr double kPeriod = kSamplePeriod;

/// The response of the true motor to its command. Each response stays within a MotorLag.
enum class Response { delay, mean, jitter, filter, mixed };

/// A motor in continuous time. The motor holds each command until the next.
class Motor {
 public:
  /// `delayed` [s]: the pure delay in a mixed lag.
  Motor(Response response, double lag, double delayed)
      : response_(response), lag_(lag), delayed_(delayed) {}

  void write(double now, const Vec3& force, double random) {
    // With a varying delay, an older command must not overtake a newer one.
    delay_ = response_ == Response::jitter  ? random * lag_
             : response_ == Response::mixed ? delayed_
                                            : lag_;
    written_.push_back({now, std::max(now + delay_, acts_), force});
    acts_ = written_.back().acts;
  }
  /// Returns the force at `now`. `step` [s]: the time since the last call.
  Vec3 force(double now, double step) {
    while (written_.size() > 1 && written_[1].acts <= now - lag_) written_.pop_front();
    if (response_ == Response::filter) {
      filtered_ += (1.0 - std::exp(-step / lag_)) * (written_.back().force - filtered_);
      return filtered_;
    }
    if (response_ == Response::mean) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t i = 0; i < written_.size(); ++i) {
        const double ends = i + 1 < written_.size() ? written_[i + 1].at : now;
        const double begins = std::max(written_[i].at, now - lag_);
        sum += std::max(0.0, ends - begins) / lag_ * written_[i].force;
      }
      return sum;
    }
    Vec3 acts = Vec3::Zero();
    for (const Written& one : written_)
      if (one.acts <= now) acts = one.force;
    if (response_ != Response::mixed) return acts;
    filtered_ += -std::expm1(-step / (lag_ - delayed_)) * (acts - filtered_);
    return filtered_;
  }

 private:
  struct Written {
    double at, acts;
    Vec3 force;
  };
  Response response_;
  double lag_, delayed_, delay_ = 0.0, acts_ = 0.0;
  std::deque<Written> written_;
  Vec3 filtered_ = Vec3::Zero();
};

/// A random device with a hand and commands that try to produce energy at its motor.
struct Adversary {
  std::mt19937_64 random;
  AccountConfig config;
  double friction, hand;
  Response response;
  double true_lag, delayed;
  bool flat;     // All movements are on a single line.
  int late = 0;  // [samples] after which the device takes a command up

  double draw(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  double draw_log(double low, double high) { return std::exp(draw(std::log(low), std::log(high))); }

  Adversary(std::uint64_t seed, double told_share) : random(seed) {
    config.period = kPeriod;
    config.translation.damping = draw_log(0.005, 5.0);
    config.translation.mass = draw_log(0.02, 0.5);
    config.translation.coulomb_friction = friction = draw(0.0, 1.0) < 0.5 ? 0.0 : draw(0.01, 0.3);
    config.translation.outside_force = draw(2.0, 15.0);
    // The margin covers the integration error of the motion.
    hand = 0.9 * config.translation.outside_force;
    response = static_cast<Response>(seed % 5);
    const bool filter = response == Response::filter, mixed = response == Response::mixed;
    const double lag = draw(0.05, filter || mixed ? 0.9 : 2.5) * kPeriod;
    true_lag = draw(0.0, 1.0) < 0.5 ? lag : draw(0.02, 1.0) * lag;
    delayed = draw(0.0, 0.98) * true_lag;
    config.lag = {.time = told_share * lag,
                  .kind = filter  ? LagKind::filter
                          : mixed ? LagKind::mixed
                                  : LagKind::delay};
    flat = draw(0.0, 1.0) < 0.5;
  }

  /// Returns the largest excess [J] of the motor's energy over the dissipated energy, at any time.
  double most_made(AccountStatistics& statistics, bool told_late = true) {
    constexpr int kSteps = 100, kSamples = 480;
    constexpr double kStep = kPeriod / kSteps;
    config.late = told_late ? late : 0;
    PortAccount account(config);
    Motor motor(response, true_lag, delayed);
    std::deque<Command> coming(static_cast<std::size_t>(late));
    const double mass = config.translation.mass * (draw(0.0, 1.0) < 0.5 ? 1.0 : draw(1.0, 3.0));
    const double damping = config.translation.damping.least();
    Vec3 x = Vec3::Zero(), v = Vec3::Zero(), seen = Vec3::Zero(), push = Vec3::Zero();
    const Vec3 line = random_direction();
    double made = 0.0, most = 0.0;
    const double swing = draw(2e-3, 40e-3), reaction = draw(0.0, 1.0);
    for (int n = 0; n < kSamples; ++n) {
      const Vec3 moved = n == 0 ? Vec3::Zero() : Vec3(x - seen);
      seen = x;
      const Command given = account.step(sample(moved, wanted(n, moved, v, line)));
      coming.push_back(given);
      account.set_held(coming.front());
      motor.write(n * kPeriod, coming.front().force(), draw(0.0, 1.0));
      coming.pop_front();
      // integration step of the reversal within the sample
      const int turn = static_cast<int>(draw(0.0, kSteps));
      for (int i = 0; i < kSteps; ++i) {
        const double now = n * kPeriod + (i + 0.5) * kStep;
        const Vec3 force = motor.force(now, kStep);
        if (i == 0 || i == turn) push = pushes(now, swing, reaction, force, v, line);
        Vec3 after = (mass * v + kStep * (force + push)) / (mass + kStep * damping);
        const double stops = kStep * friction / mass, speed = after.norm();
        after = speed <= stops ? Vec3(Vec3::Zero()) : Vec3((1.0 - stops / speed) * after);
        const Vec3 mean = 0.5 * (v + after);
        v = after;
        x += kStep * mean;
        made += kStep * (force.dot(mean) - damping * mean.squaredNorm() - friction * mean.norm());
        most = std::max(most, made);
      }
    }
    statistics = account.statistics();
    return most;
  }

  Vec3 random_direction() {
    const Vec3 any(draw(-1, 1), flat ? 0.0 : draw(-1, 1), flat ? 0.0 : draw(-1, 1));
    return flat ? Vec3(Vec3::UnitX()) : direction(any);
  }
  /// Commands alternate: along the movement, a spring, along the velocity, or random.
  Command wanted(int n, const Vec3& moved, const Vec3& v, const Vec3& line) {
    constexpr double kMost = 10.0;
    switch ((n / 60) % 4) {
      case 0:
        return push_of(kMost * direction(moved));
      case 1:
        return push_of(-2e4 * line * line.dot(seen_ += moved));
      case 2:
        return push_of(draw(0.0, 1.0) < 0.7 ? Vec3(kMost * direction(v)) : Vec3(Vec3::Zero()));
      default:
        return push_of(draw(0.0, kMost) * random_direction());
    }
  }
  static Command push_of(const Vec3& force) { return test::push(force); }
  /// The hand oscillates, follows the motor's force or reverses against it within the sample.
  Vec3 pushes(double now, double swing, double reaction, const Vec3& force, const Vec3& v,
              const Vec3& line) {
    if (draw(0.0, 1.0) < reaction) return hand * direction(draw(0.0, 1.0) < 0.5 ? force : v);
    if (draw(0.0, 1.0) < 0.2) return hand * random_direction();
    return hand * (std::sin(2.0 * std::numbers::pi * now / swing) > 0.0 ? 1.0 : -1.0) * line;
  }

 private:
  Vec3 seen_ = Vec3::Zero();
};

/// Tests 480 devices with delay, mean, jitter, filter and mixed response. The true lag is at most
/// the declared lag of up to 2.5 periods.
TEST(AccountLag, NoMotorWithinItsLagMakesEnergy) {
  std::uint64_t reduced = 0;
  for (std::uint64_t seed = 0; seed < 480; ++seed) {
    Adversary adversary(seed, 1.0);
    AccountStatistics statistics;
    const double made = adversary.most_made(statistics);
    EXPECT_LE(made, 1e-9) << seed << " lag " << adversary.config.lag.time << " true "
                          << adversary.true_lag << " response "
                          << static_cast<int>(adversary.response);
    EXPECT_EQ(statistics.overdrawn, 0u) << seed;
    EXPECT_EQ(statistics.strong_hand, 0u) << seed;
    reduced += statistics.reduced;
  }
  EXPECT_GT(reduced, 480u * 100u);  // The commands must often exceed the bound.
}

/// Tests 480 devices that take commands up 1, 2 and 4 samples late, after which their motors lag.
TEST(AccountLag, NorWhereItsForcesAreTakenUpLate) {
  std::uint64_t reduced = 0;
  int untold = 0;
  for (std::uint64_t seed = 0; seed < 480; ++seed) {
    const int late = std::array{1, 2, 4}[seed / 5 % 3];
    Adversary adversary(seed, 1.0);
    adversary.late = late;
    AccountStatistics statistics;
    const double made = adversary.most_made(statistics);
    EXPECT_LE(made, 1e-9) << seed << " late " << late << " lag " << adversary.config.lag.time
                          << " response " << static_cast<int>(adversary.response);
    EXPECT_EQ(statistics.overdrawn, 0u) << seed;
    EXPECT_EQ(statistics.strong_hand, 0u) << seed;
    reduced += statistics.reduced;
    // If the account knows only the lag, the same hands gain energy.
    Adversary same(seed, 1.0);
    same.late = late;
    untold += same.most_made(statistics, false) > 1e-6 ? 1 : 0;
  }
  EXPECT_GT(reduced, 480u * 100u);  // The commands must often exceed the bound.
  EXPECT_GT(untold, 100);
}

/// A resting hand commands far more force than the balance covers. The force must settle.
TEST(AccountLag, AForceThatIsLateTooDoesNotSwingAtItsLimit) {
  for (const double force : {0.1, 1.0, 3.0})
    for (const int late : {1, 2, 4}) {
      DeviceSpec spec = builtin_device("simulated");
      spec.actuation.late_ticks = late;
      spec.actuation.lag = 0.3e-3;
      const AccountConfig config = account_config(spec, kPeriod);
      PortAccount account(config);
      for (int n = 0; n < 3; ++n) account.step(sample(Vec3::Zero(), {}));
      account.credit(need_at_rest(config, push(Vec3(force, 0, 0))));
      double before = 0.0;
      for (int n = 0; n < 300; ++n) {
        const double given = account.step(sample(Vec3::Zero(), push(Vec3(8, 0, 0)))).elastic.x();
        if (n > 150) {
          ASSERT_NEAR(given, before, 2e-3 * before) << force << ' ' << late << ' ' << n;
        }
        before = given;
      }
      EXPECT_GT(before, 0.5 * force) << late;
    }
}

/// Returns the mean missing share of a step over a sample of `time` [s] that begins `age` [s] after
/// the step. `delayed` [s] is the pure delay. The rest of the lag is first-order.
double share_left(double age, double time, double lag, double delayed) {
  const double full = std::clamp(delayed - age, 0.0, time), from = std::max(age, delayed);
  if (!(age + time > from) || !(lag - delayed > 1e-12)) return full / time;
  const double rest = lag - delayed;
  return (full +
          rest * (std::exp((delayed - from) / rest) - std::exp((delayed - age - time) / rest))) /
         time;
}

TEST(AccountLag, AMixedLagIsWorstAtOneEnd) {
  constexpr int kParts = 100;
  for (int n = 1; n <= 60; ++n) {
    const double lag = 2.0 * kPeriod * n / 60;
    const LaggingForces forces({.time = lag, .kind = LagKind::mixed});
    for (int k = 0; k <= 60; ++k) {
      const double age = 4.0 * kPeriod * k / 60;
      if (age >= forces.lag().rest()) break;  // The account ignores older forces.
      for (int i = 0; i <= kParts; ++i)
        EXPECT_LE(share_left(age, kPeriod, lag, lag * i / kParts),
                  forces.share(age, 0.0, kPeriod) + 1e-12)
            << lag << ' ' << age << ' ' << i;
    }
  }
}

/// Returns the energy [J] that a change of the force by `change` [N] can give in a share of a
/// period.
double turn_energy(const PortBalance& port, double change, double strongest, double share) {
  return port.turn_limit(strongest, kPeriod).energy(change, TurnLimit::spread(share));
}

/// With a delay of 0.3 T, the older force acts for three tenths of a uniform movement. The account
/// also subtracts the extra energy of a hand that reverses within the sample.
TEST(AccountLag, AnEvenMovementIsChargedByShares) {
  AccountConfig config = handle(2.0);
  config.lag = {.time = 0.3 * kPeriod};
  PortAccount account(config);
  account.step(sample(Vec3(1e-3, 0, 0), {}));  // dissipates 2 mJ
  const Command first = account.step(sample(Vec3::Zero(), push(Vec3(0.5, 0, 0))));
  ASSERT_EQ(first.elastic.x(), 0.5);
  const Command second = account.step(sample(Vec3::Zero(), push(Vec3(0.2, 0, 0))));
  ASSERT_EQ(second.elastic.x(), 0.2);
  const double before = account.balance(), dx = 1e-4;
  account.step(sample(Vec3(dx, 0, 0), {}));
  const PortBalance port(config.translation, kPeriod);
  const double turns = turn_energy(port, 0.3, 0.5, 0.3);
  EXPECT_GT(turns, 0.0);
  EXPECT_NEAR(account.balance(),
              before + 2.0 * dx * dx / kPeriod - (0.7 * 0.2 + 0.3 * 0.5) * dx - turns, 1e-15);
  // When the force grows, the account uses the newer force.
  const Command third = account.step(sample(Vec3::Zero(), push(Vec3(0.5, 0, 0))));
  ASSERT_EQ(third.elastic.x(), 0.5);
  const double then = account.balance();
  account.step(sample(Vec3(dx, 0, 0), {}));
  EXPECT_NEAR(account.balance(),
              then + 2.0 * dx * dx / kPeriod - 0.5 * dx - turn_energy(port, 0.5, 0.5, 0.3), 1e-15);
}

/// A hand acts against a pure delay d, and the force changes by c at the best time. In closed form,
/// the hand gets at most c^2 h/(4 b) d/h (1 - d/h) beyond the mean.
TEST(AccountLag, ATurnWithinASampleGivesWhatIsCharged) {
  const double b = 0.5, change = 3.0;
  AccountConfig config;
  config.translation.damping = b;
  const PortBalance port(config.translation, kPeriod);
  for (const double share : {0.1, 0.3, 0.5, 0.8, 1.0}) {
    double most = 0.0;  // maximum over delays up to `share` and both speeds of a hand
    for (int d = 1; d <= 100; ++d) {
      const double delay = std::min(share, 0.01 * d) * kPeriod;
      // [m/s] the best speed for the hand
      const double out = change / (2.0 * b) * (1.0 - delay / kPeriod);
      const double way = out * delay;
      most = std::max(most, change * way - b * way * way * (1.0 / delay + 1.0 / (kPeriod - delay)));
    }
    EXPECT_NEAR(turn_energy(port, change, change, share), most, 1e-3 * most) << share;
  }
}

TEST(AccountLag, ALagThatCannotBeReckonedWithIsRefused) {
  AccountConfig config = handle();
  config.lag = {.time = (LaggingForces::kMostSamples + 0.1) * kPeriod};
  EXPECT_THROW(PortAccount{config}, std::invalid_argument);
  config.lag = {.time = 1.1 * kPeriod, .kind = LagKind::filter};
  EXPECT_THROW(PortAccount{config}, std::invalid_argument);
  config.lag = {.time = 0.3 * kPeriod};
  EXPECT_NO_THROW(PortAccount{config});
  config.late = 1;
  EXPECT_NO_THROW(PortAccount{config});
}

TEST(AccountLag, TheSpecificationOfTheDeviceTells) {
  DeviceSpec spec = builtin_device("simulated");
  EXPECT_EQ(account_config(spec, kPeriod).lag.time, 0.0);
  spec.actuation.lag = 3e-4;
  spec.actuation.kind = LagKind::filter;
  for (const AccountConfig& config :
       {account_config(spec, kPeriod), any_hand_account(spec, kPeriod)}) {
    EXPECT_EQ(config.lag.time, 3e-4);
    EXPECT_EQ(config.lag.kind, LagKind::filter);
  }
}

/// Without the lag in the account, the same hands must gain energy.
TEST(AccountLag, UntoldItMakesEnergy) {
  int won = 0;
  for (std::uint64_t seed = 0; seed < 480; ++seed) {
    Adversary adversary(seed, 0.0);
    AccountStatistics statistics;
    won += adversary.most_made(statistics) > 1e-6 ? 1 : 0;
  }
  EXPECT_GT(won, 100);
}

}  // namespace
}  // namespace feltwire::account_lag_test
