#pragma once
// A debt of the energy account that ends the force.

#include <algorithm>
#include <optional>

namespace feltwire {

/// [J] A tick that is microseconds late makes a smaller debt. A larger one is a fault: the hand got
/// energy that nothing had paid for, so the servo gives it no force any more.
inline constexpr double kLargestDebt = 3e-6;

struct Overdraft {
  double debt = 0.0;         // [J] the largest so far
  double hold_time = 0.0;    // [s] for which the force of the tick was held that made it
  bool strong_hand = false;  // a force from outside, or a speed, above the specified one made it
};

/// Judges the balance of the account, tick by tick.
class DebtGuard {
 public:
  /// `owed` [J]: the debt with which the servo begins. It is no fault of this run.
  explicit DebtGuard(double owed) : forgiven_(0.0 - owed) {}

  /// Takes the balance [J] after a hold of `hold_time` [s]. Energy burned since the beginning
  /// reduces the debt that is forgiven.
  void judge(double balance, double hold_time, bool strong_hand) noexcept {
    forgiven_ = std::clamp(balance, forgiven_, 0.0);
    if (overdraft_)
      overdraft_->debt = std::max(overdraft_->debt, -balance);
    else if (balance < forgiven_ - kLargestDebt)
      overdraft_ = {.debt = -balance, .hold_time = hold_time, .strong_hand = strong_hand};
  }
  /// Empty: there was no such debt.
  const std::optional<Overdraft>& overdraft() const noexcept { return overdraft_; }

 private:
  double forgiven_;  // [J] of the balance, 0 or less: no less is a fault
  std::optional<Overdraft> overdraft_;
};

}  // namespace feltwire
