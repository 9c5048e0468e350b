#include "core/bounding/hold_time_margin.hpp"

#include <algorithm>

namespace feltwire {

void HoldTimeMargin::saw(double hold_time, bool felt) noexcept {
  // Largest changes of the reserved time per tick, as shares of the period T. Per tick, they reduce
  // a force at its limit by at most the share 2 kGrowth, or kGrowthOfAnyHand / 2. On a device with
  // late forces, each pending force adds the same amount.
  constexpr double kGrowth = 0.005, kGrowthOfAnyHand = 0.03, kShrinkage = 0.001, kAtOnce = 1.0;
  const auto follow = [&](double reserved, double growth, double most) {
    return std::clamp(most, reserved - kShrinkage * period_, reserved + growth * period_);
  };
  // The delay of this tick counts from the next tick on. For this tick, the reachable displacement
  // already includes the delay.
  reserved_ = follow(reserved_, kGrowth, std::max(over_, over_before_));
  over_ = std::max(over_, std::min(hold_time - period_, period_));
  window_ += hold_time;
  if (window_ >= kWindow) {
    over_before_ = over_;
    over_ = window_ = 0.0;
  }
  const double over = std::max(over_, over_before_);
  const double twice = std::min(2.0 * over, period_);
  reserved_of_any_hand_ = follow(reserved_of_any_hand_, felt ? kGrowthOfAnyHand : kAtOnce, twice);
}

}  // namespace feltwire
