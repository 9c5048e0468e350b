#pragma once
// The account of a haptic port: how much force the energy that the device certainly burned can pay
// for, whatever the hand does next.
//
// docs/bounding.md, "The account", has the derivation and the proof. The methods beside this one
// are laws for a contact. This is no law for a contact: it is the last bound before the safety
// stage, behind any of them.

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/numeric.hpp"
#include "core/bounding/certain_path.hpp"
#include "core/bounding/outside_force.hpp"
#include "core/bounding/reach.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

struct AccountConfig {
  double period = 1e-3;  // T [s] the longest time that one force is meant to be held
  PortKnowledge translation{}, rotation{};
  /// [J] the most that is kept while no force is held: what free motion can save for one contact. A
  /// larger cap gives the full force at the first touch. A smaller cap takes less energy from the
  /// hand when a command is wrong.
  double cap = std::numeric_limits<double>::infinity();
  /// A force that follows the balance must look half a sample ahead. One whose bound is passive by
  /// itself is cut only where that bound was wrong, and needs no look ahead.
  bool looks_ahead = true;
  /// Takes the largest force from outside that was seen lately instead of the one that was told,
  /// where that is less (core/bounding/outside_force.hpp).
  bool learns_outside_force = false;
};

/// Counts of the account.
struct AccountStatistics {
  std::uint64_t reduced = 0;      // samples whose command was scaled down
  std::uint64_t overdrawn = 0;    // times that the balance fell below zero
  double largest_debt = 0.0;      // [J] its largest depth below zero
  std::uint64_t strong_hand = 0;  // samples that only a force beyond outside_force, or a speed
                                  // beyond the one that was told, explains
};

/// need(s f) of one port over the scale s of a wanted force f [J]: first s^2 up to s = turn, as for
/// a hand that may move the handle any distance, then second s^2 + linear s + constant. Continuous,
/// with a continuous slope, increasing and convex. Infinite for every s > 0 where nothing is known
/// that would limit it.
struct EnergyNeed {
  double first = 0.0, turn = std::numeric_limits<double>::infinity();
  double second = 0.0, linear = 0.0, constant = 0.0;
  bool limited() const noexcept {
    return first < std::numeric_limits<double>::infinity() ||
           turn < std::numeric_limits<double>::infinity();
  }
  double at(double s) const noexcept {
    return s < turn ? first * s * s : (second * s + linear) * s + constant;
  }
};

/// The balance M(n) of one port: the energy that the device certainly burned less what the held
/// force delivered to the hand, both as the encoder shows them.
class PortBalance {
 public:
  /// Precondition: validate(known) passed, period > 0.
  PortBalance(const PortKnowledge& known, double period, bool learns = false);

  /// [J] what one sample adds: dx'B dx / h + f_c |path| - f(n-1).dx, h = max(T, hold_time).
  double earned(const Vec3& displacement, const Vec3& held, double hold_time) noexcept;
  /// Whether the sample that earned() was told last shows a force from outside beyond what was
  /// told, or a speed beyond it.
  bool strong_hand() const noexcept { return strong_hand_; }
  /// [N] the bound of the force from outside that it reckons with.
  double outside_force() const noexcept {
    return learned_ ? learned_->bound() : known_.outside_force;
  }
  /// The last movement is not known.
  void forget() noexcept;
  /// The energy that the next sample can take at most while a share of `wanted` is held, if it is
  /// held for `hold_time` h [s], T or longer. A longer hold burns less for the same way: b/h.
  EnergyNeed need(const Vec3& wanted, double hold_time) const noexcept;
  /// The next need() is asked for `hold_time` [s]: what follows from it alone is kept, for it
  /// seldom changes.
  void prepare(double hold_time) noexcept;
  /// [J] the same of a hand that may move the handle any distance, of all of `wanted`.
  double need_of_any_hand(const Vec3& wanted, double hold_time) const noexcept;

 private:
  /// What a hold of some length makes of the damping and of the mass.
  struct Hold {
    double time = 0.0;        // h [s]
    double free = 0.0;        // h / (2 b) [m/N] infinite without damping
    double burned = 0.0;      // b / h [N/m]
    double per_newton = 0.0;  // h^2 / (2 m) [m/N]
  };
  Hold hold_of(double damping, double hold_time) const noexcept;
  double damping_along(const Vec3& unit) const noexcept;
  bool beyond_reach(const Vec3& displacement, const Vec3& held, double hold_time) const noexcept;
  void limit_by_inertia(EnergyNeed& need, const Polar<double>& force,
                        const Hold& hold) const noexcept;
  void limit_by_speed(EnergyNeed& need, const Polar<double>& force,
                      const Hold& hold) const noexcept;

  PortKnowledge known_;
  double period_;
  bool directional_;  // the damping differs by direction, and every direction has some
  Mat3 inverse_damping_ = Mat3::Zero();
  Reach reach_;
  CertainPath path_;
  Hold hold_;  // that was prepared; without a use where the damping differs by direction
  std::optional<OutsideForce> learned_;
  bool limits_speed_;
  bool too_fast_ = false;  // the last sample was faster than was told
  bool strong_hand_ = false;
};

/// Force and torque as one port:
///
///   M(n) = M(n-1) + earned by translation and rotation,      at most `cap` while nothing is held
///   f(n) = s f_e(n), the largest 0 <= s <= 1 with need(f(n)) <= min(M(n), A(n))
///   A(n) = M(n) - (T/h) f(n-1).dx / 2,  h = max(T, hold time): M half a sample ahead; M(n)
///          where it does not look ahead
///   need(f) = max of f.y - b_u y^2 / T over 0 <= y <= reach     b_u = 1 / (u' B^-1 u), u = f / |f|
///   reach   = the less of what mass and force from outside allow (core/bounding/reach.hpp) and
///             v h + q |u|_1, where these are known
///
/// A(n) is no part of the proof: a smaller force is always admissible. A force that only followed
/// M(n) would be a spring that is always half a sample late, and would shake (docs/bounding.md,
/// "The cut looks ahead").
///
/// The needs of force and torque add up and one s scales both, so that the direction stays. A part
/// whose need has no limit (no damping and no mass is known) is not rendered.
///
/// Guarantee: M >= 0 after every sample, up to rounding, while no hold lasts longer than T, the
/// handle has at least the mass that was told, and the force from outside stays at or below what
/// was told. Where that is broken the account overdraws once; then it renders nothing until the
/// device has burned the debt. Every reduction of what it returns is admissible when set_held()
/// tells it.
///
/// Nothing here allocates, throws after construction or reads a clock.
class PortAccount {
 public:
  /// Throws std::invalid_argument naming the parameter and the remedy.
  explicit PortAccount(const AccountConfig& config);

  /// One servo sample: how the device moved while the last force was held, and what is wanted next,
  /// to be held for `next_hold` [s] at most; T where it is shorter. Returns what may be held and
  /// takes that as held. A sample with anything not finite, or that
  /// did not take any time, loses the balance and renders nothing.
  Command step(const BoundingStep& step, double next_hold = 0.0) noexcept;

  /// Says what was really held after the last step, where that differs.
  void set_held(const Command& held) noexcept { held_ = held; }

  /// Adds `energy` >= 0 [J] that another port of the same system took in and that this one may give
  /// to the hand. The guarantee is then: delivered to the hand <= burned + all that was added. The
  /// caller sees to it that the other port has it (core/teleoperation/energy_counters.hpp).
  void credit(double energy) noexcept {
    if (energy > 0.0 && std::isfinite(energy)) balance_ += energy;
  }

  /// [J] f'B^-1 f h / 4: what holding `command` for h [s] can give to a hand that may move the
  /// handle any distance.
  double need_of_any_hand(const Command& command, double hold_time) const noexcept {
    return translation_.need_of_any_hand(command.force(), hold_time) +
           rotation_.need_of_any_hand(command.torque, hold_time);
  }

  double balance() const noexcept { return balance_; }  // M [J]
  /// [N] the bound of the force from outside that it reckons with: told, or learned.
  double outside_force() const noexcept { return translation_.outside_force(); }
  bool in_debt() const noexcept { return balance_ < 0.0; }
  const AccountStatistics& statistics() const noexcept { return statistics_; }

 private:
  double take_in(const BoundingStep& step) noexcept;
  void count_debt(bool was_in_debt) noexcept;

  double cap_;
  bool looks_ahead_;
  PortBalance translation_, rotation_;
  double period_;
  Command held_;
  double balance_ = 0.0;
  AccountStatistics statistics_;
};

/// [J] what a handle that rests with `command` held can take in the next sample. Of the device's
/// largest force it is a natural value for AccountConfig::cap.
double need_at_rest(const AccountConfig& config, const Command& command);

}  // namespace feltwire
