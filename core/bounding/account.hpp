#pragma once
// The account of a haptic port: the largest force that the energy, which the device certainly
// burned, covers for every next movement of the hand.
//
// docs/bounding.md, "The account", has the derivation and the proof. The methods in this folder
// are laws for a contact. The account is not a law for a contact: it is the last bound before the
// safety stage, after any of them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "core/base/numeric.hpp"
#include "core/bounding/hand_force_bound.hpp"
#include "core/bounding/lagging_forces.hpp"
#include "core/bounding/path_lower_bound.hpp"
#include "core/bounding/reachable_displacement.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

struct AccountConfig {
  double period = 1e-3;  // T [s] the longest intended hold time of one force
  PortKnowledge translation{}, rotation{};
  /// [J] largest balance while no force is held: free motion can save this much for one contact. A
  /// larger cap gives the full force at the first touch. A smaller cap takes less energy from the
  /// hand when a command is wrong.
  double cap = std::numeric_limits<double>::infinity();
  /// A force that follows the balance must look half a sample ahead. After a bound that is passive
  /// on its own the account cuts only after an error, and needs no look ahead.
  bool looks_ahead = true;
  /// Uses the largest recent force from outside instead of the specified one, if it is less
  /// (core/bounding/hand_force_bound.hpp).
  bool learns_outside_force = false;
  /// L: the samples by which the device takes a force up late. The force of sample n is on the hand
  /// from sample n + L on. From 0 to kMostLate.
  int late = 0;
  static constexpr int kMostLate = 4;
  /// The most by which the motor follows its commands later than that. MotorLag::rest() is from 0
  /// to LaggingForces::kMostSamples periods.
  MotorLag lag{};
};

inline constexpr double kOffByRounding = 1e-12;  // more than the arithmetic of a step rounds off
/// After a tick that is late, a small force falls to this share of itself at once, and no farther
/// (docs/bounding.md, "After a tick that is late").
inline constexpr double kSoftFall = 0.955;

/// Counts of the account.
struct AccountStatistics {
  std::uint64_t reduced = 0;      // samples whose command was scaled down
  std::uint64_t overdrawn = 0;    // times that the balance fell below zero
  double largest_debt = 0.0;      // [J] its largest depth below zero
  std::uint64_t strong_hand = 0;  // samples that only a force above outside_force, or a speed
                                  // above the specified one, explains
};

/// need(s f) of one port over the scale s of a wanted force f [J]: first s^2 up to the turn, as for
/// a hand that may move the handle any distance, then second s^2 + linear s - burned / squared.
/// Continuous, with a continuous slope, increasing and convex. Infinite for every s > 0 where
/// nothing is known that would limit it.
struct EnergyNeed {
  double first = 0.0;  // [J]
  /// The turn is at s = reach / free. `free` [J]: f times the movement that takes the most of f,
  /// less the way by which f itself moves the handle farther. `reach` [J]: f times the way that the
  /// handle moves at most without f.
  double free = 0.0, reach = std::numeric_limits<double>::infinity();
  double second = 0.0, linear = 0.0;   // [J]
  double burned = 0.0, squared = 1.0;  // [J N^2], [N^2]: divided only where that matters

  bool limited() const noexcept {
    return first < std::numeric_limits<double>::infinity() ||
           reach < std::numeric_limits<double>::infinity();
  }
  bool before_turn(double s) const noexcept { return s * free < reach; }
  double at(double s) const noexcept {
    return before_turn(s) ? first * s * s : (second * s + linear) * s - burned / squared;
  }
  /// [J] as much as at(1) or more.
  double most() const noexcept { return before_turn(1.0) ? first : second + linear; }
};

/// The most that a hand which turns within a sample gets beyond the mean force of a motor that
/// changes its force meanwhile (docs/bounding.md, "A motor that lags").
struct TurnLimit {
  double by_damping = 0.0;  // h / (4 b) [m/N]
  double by_mass = 0.0;     // h^2 / (2 m) [m/N]
  double outside = 0.0;     // [N] the largest force from outside and of the motor together

  /// s (1 - s), for the share of the sample in which the force may change, and s = 1/2 at most.
  static double spread(double share) noexcept {
    constexpr double kHalf = 0.5;
    const double part = std::min(share, kHalf);
    return part > 0.0 ? part * (1.0 - part) : 0.0;
  }
  /// [J] for a change of the force by `change` >= 0 [N].
  double energy(double change, double spread) const noexcept {
    if (!(change > 0.0) || !(spread > 0.0)) return 0.0;
    return spread * change * std::min(change * by_damping, (outside + change) * by_mass);
  }
};

/// The balance M(n) of one port: the energy that the device certainly burned, minus the energy that
/// the held force delivered to the hand, both as the encoder measures them.
class PortBalance {
 public:
  /// Precondition: validate(known) passed, period > 0.
  PortBalance(const PortKnowledge& known, double period, bool learns = false);

  /// [J] energy that one sample adds: dx'B dx / h + f_c |path| - f(n-1).dx, h = max(T, hold_time).
  double earned(const Vec3& displacement, const Vec3& held, double hold_time) noexcept {
    return earned(displacement, held, hold_time, LaggingForces());
  }
  /// earned() where the motor may still have held a part of `older` forces.
  double earned(const Vec3& displacement, const Vec3& held, double hold_time,
                const LaggingForces& older) noexcept;
  /// Whether the last sample of earned() shows a force from outside, or a speed, above the
  /// specified one.
  bool strong_hand() const noexcept { return strong_hand_; }
  /// [N] the assumed bound of the force from outside.
  double outside_force() const noexcept {
    return learned_ ? learned_->bound() : known_.outside_force;
  }
  /// The last movement is not known.
  void forget() noexcept;
  /// The energy that the next sample can take at most while a share of `wanted` is held, if it is
  /// held for `hold_time` h [s], T or longer. A longer hold burns less for the same way: b/h.
  /// `coming`: the forces that are held before it, each for a sample, or a part of each.
  EnergyNeed need(const Vec3& wanted, double hold_time,
                  std::span<const Vec3> coming = {}) const noexcept;
  /// need() of a force in a sample before which there are `samples`, in all of which a force of
  /// `strongest` [N] along any direction may be on the motor.
  EnergyNeed need_after(const Vec3& wanted, double hold_time, int samples,
                        double strongest) const noexcept;
  /// For a sample of `hold_time` [s] in which no force of the motor is above `strongest` [N].
  TurnLimit turn_limit(double strongest, double hold_time) const noexcept;
  /// q [m]
  double quantum() const noexcept { return known_.quantum; }
  /// Prepares need() for `hold_time` [s]: it keeps the values that follow from the hold time alone,
  /// because that seldom changes.
  void prepare(double hold_time) noexcept;
  /// Keeps a share of the balance for the samples after a tick that is late (docs/bounding.md,
  /// "After a tick that is late"), on a device that takes forces up `late` samples late.
  void keep_for_late_ticks(int late) noexcept;
  /// The largest share that kept_beside() ever returns beside a force.
  double most_kept() const noexcept { return std::max({0.0, kept_, kept_ + 2.0 * kept_aside_}); }
  /// That share while `held` [N] is held; kBesideNothing for none, beside which another port
  /// decides.
  static constexpr double kBesideNothing = 1.0;
  double kept_beside(const Vec3& held) const noexcept {
    constexpr double kSmall = 0.4;  // of the force from outside, which makes most of the reach then
    const double squared = held.squaredNorm(), most = kSmall * outside_force();
    if (squared == 0.0) return kBesideNothing;
    if (!keeps_ || !(squared < most * most)) return 0.0;
    const double sum = held.lpNorm<1>();
    const double kept = kept_ + kept_aside_ * (sum * sum / squared - 1.0);
    return kept > 0.0 ? kept * (1.0 - squared / (most * most)) : 0.0;
  }
  /// [J] the same for a hand that may move the handle any distance, for the whole of `wanted`.
  double need_of_any_hand(const Vec3& wanted, double hold_time) const noexcept;

 private:
  /// The effects of damping and mass over a hold of some length.
  struct Hold {
    double time = 0.0;        // h [s]
    double free = 0.0;        // h / (2 b) [m/N] infinite without damping
    double burned = 0.0;      // b / h [N/m]
    double per_newton = 0.0;  // h^2 / (2 m) [m/N]
    double second = 0.0;      // [m/N] of the form beyond the turn, for each newton^2
    double linear = 0.0;      // the same, for each newton of the reach
  };
  /// A force, and what follows from it alone.
  struct Force {
    const Vec3& vector;
    double squared, length;
  };
  Hold hold_of(double damping, double hold_time) const noexcept;
  double damping_along(const Vec3& force) const noexcept;
  bool beyond_reach(const Vec3& displacement, const Vec3& held, double hold_time) const noexcept;
  /// `farther` [J]: what other forces add to the reach.
  void limit_by_inertia(EnergyNeed& need, const Force& force, const Hold& hold,
                        double farther) const noexcept;
  template <class Farther>
  EnergyNeed need_of(const Vec3& wanted, double hold_time, Farther farther) const noexcept;
  double charged_for_lag(const Vec3& displacement, const Vec3& held, double hold_time,
                         const LaggingForces& older) const noexcept;
  void limit_by_speed(EnergyNeed& need, const Force& force, const Hold& hold) const noexcept;

  PortKnowledge known_;
  double period_;
  bool directional_;  // the damping differs by direction, and every direction has some
  Mat3 inverse_damping_ = Mat3::Zero();
  ReachableDisplacement reach_;
  PathLowerBound path_;
  Hold hold_;  // the prepared one; not used if the damping differs by direction
  std::optional<HandForceBound> learned_;
  bool limits_speed_;
  bool too_fast_ = false;  // the last sample was faster than specified
  bool strong_hand_ = false;
  // The kept share along an axis, and the increase for each unit of |u|_1^2 above 1.
  double kept_ = 0.0, kept_aside_ = 0.0;
  bool keeps_ = false;
};

/// Force and torque as one port:
///
///   M(n) = M(n-1) + earned by translation and rotation,      at most `cap` while nothing is held
///   f(n) = s f_e(n), the largest 0 <= s <= 1 with need(f(n)) <= min(M(n), A(n))
///   A(n) = M(n) - (T/h) f(n-1).dx / 2,  h = max(T, hold time): M half a sample ahead; M(n)
///          where it does not look ahead
///   need(f) = max of f.y - b_u y^2 / T over 0 <= y <= reach     b_u = 1 / (u' B^-1 u), u = f / |f|
///   reach   = the smaller of the reach of mass and outside force
///   (core/bounding/reachable_displacement.hpp) and of
///             v h + q |u|_1, if these are known
///
/// If the device takes a force up L samples late, the coming forces f(n-L) to f(n-1) need energy
/// before f(n) does (docs/bounding.md, "Forces that are taken up late"):
///
///   need(f(n)) <= min(M(n), A(n)) - need(f(n-L)) - ... - need(f(n-1)),   A(n) L + 1/2 samples
///   ahead
///
/// If the motor follows its commands with a lag, a part of an older force may be on the hand in
/// this sample, and a part of f(n) in later ones (core/bounding/lagging_need.hpp; docs/bounding.md,
/// "A motor that lags"). Both may be so: then the lag begins where the force is taken up.
///
/// A(n) is not part of the proof: a smaller force is always admissible. A force that only followed
/// M(n) would be a spring that is always half a sample late, and would shake (docs/bounding.md,
/// "The cut looks ahead").
///
/// The needs of force and torque add up and one s scales both, so that the direction stays. A part
/// with an infinite need (no damping and no mass is known) is not rendered.
///
/// Guarantee: M >= 0 after every sample, up to rounding, while no hold lasts longer than T, each
/// force is taken up exactly L samples late (or each at once), the handle has at least the
/// specified mass, and the force from outside is at most the specified force. If one of these is
/// broken, the account overdraws once; then it renders no force until the device has burned the
/// debt. Every reduction of the returned force is admissible if set_held() reports it.
///
/// Nothing here allocates, throws after construction or reads a clock.
class PortAccount {
 public:
  /// Throws std::invalid_argument naming the parameter and the remedy.
  explicit PortAccount(const AccountConfig& config);

  /// Takes a servo sample: the movement of the device while the last force was held, and the wanted
  /// force, for a hold of at most `next_hold` [s] (T if it is shorter). Returns the allowed force.
  /// It assumes that the device now holds this force, or on a late device the force of L samples
  /// before. A sample without a duration, or with a number that is not finite, loses the balance
  /// and renders no force.
  Command step(const BoundingStep& step, double next_hold = 0.0) noexcept;

  /// Sets the force that was really held after the last step, if it differs.
  void set_held(const Command& held) noexcept { held_ = {held.force(), held.torque}; }

  /// Adds `energy` >= 0 [J] that another port of the same system took in and that this one may give
  /// to the hand. The guarantee is then: delivered to the hand <= burned + all that was added. The
  /// caller guarantees that the other port has it (core/teleoperation/energy_counters.hpp).
  void credit(double energy) noexcept {
    if (energy > 0.0 && std::isfinite(energy)) balance_ += energy;
  }

  /// Another law bounds the port from now on, and this is its account: it goes on from that of the
  /// law before, with its balance, its debt and the forces that are still to come. What is learned
  /// of the hand and its speed begins anew. Precondition: both are of the same device.
  void go_on_from(const PortAccount& before) noexcept;
  /// Begins with a debt of `energy` >= 0 [J], and nothing held.
  void begin_in_debt(double energy) noexcept;

  /// [J] f'B^-1 f h / 4: the most that holding `command` for h [s] gives to a hand that may move
  /// the handle any distance.
  double need_of_any_hand(const Command& command, double hold_time) const noexcept {
    return translation_.need_of_any_hand(command.force(), hold_time) +
           rotation_.need_of_any_hand(command.torque, hold_time);
  }

  double balance() const noexcept { return balance_; }  // M [J]
  /// [N] the assumed bound of the force from outside: specified, or learned.
  double outside_force() const noexcept { return translation_.outside_force(); }
  bool in_debt() const noexcept { return balance_ < 0.0; }
  const AccountStatistics& statistics() const noexcept { return statistics_; }

 private:
  /// The force and the torque of a command.
  struct ForceAndTorque {
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    bool nothing() const noexcept { return force.isZero(0.0) && torque.isZero(0.0); }
  };
  static constexpr double kNoLimit = -1.0;  // no share
  double take_in(const BoundingStep& step) noexcept;
  bool idle() const noexcept;
  bool lags() const noexcept { return older_forces_.lag().time > 0.0; }
  double affordable_share(const ForceAndTorque& wanted, double left, double hold) noexcept;
  Command give_limited_part(const Command& command, double left, double hold) noexcept;
  using Needs = std::array<EnergyNeed, 2>;  // of a force and a torque
  double share_after_coming(const Needs& own, const ForceAndTorque& wanted, double left,
                            double hold) noexcept;
  struct Last {
    const Vec3 &force, &torque;
  };
  Last last() const noexcept;
  double kept() const noexcept;
  double softened(const ForceAndTorque& wanted, double usual, double most) const noexcept;
  double need_after(const ForceAndTorque& held, std::size_t n, double hold) const noexcept;
  double lagging_share(const ForceAndTorque& wanted, double left, double hold) noexcept;
  double lagging_share_after_coming(const ForceAndTorque& wanted, double left,
                                    double hold) noexcept;
  void give(const ForceAndTorque& given) noexcept;
  void count_debt(bool was_in_debt) noexcept;

  double cap_;
  bool looks_ahead_;
  PortBalance translation_, rotation_;
  double period_;
  ForceAndTorque held_;
  // Given but not yet on the hand: the first of these is taken up next.
  std::array<Vec3, AccountConfig::kMostLate> coming_forces_, coming_torques_;
  std::size_t late_;
  LaggingForces older_forces_, older_torques_;
  double surely_paid_ = 1.0;  // the share of a balance of which nothing is ever kept
  double worst_next_ = 0.0;   // [J] the balance is not less than this after the next sample
  double balance_ = 0.0;
  AccountStatistics statistics_;
};

/// [J] the most that a resting handle can take in the next sample while `command` is held. For the
/// device's largest force it is a natural value for AccountConfig::cap.
double need_at_rest(const AccountConfig& config, const Command& command);

}  // namespace feltwire
