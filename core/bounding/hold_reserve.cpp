#include "core/bounding/hold_reserve.hpp"

#include <algorithm>

namespace feltwire {

void HoldReserve::saw(double hold_time) noexcept {
  over_ = std::max(over_, hold_time - period_);
  window_ += hold_time;
  if (!(window_ >= kWindow)) return;
  over_before_ = over_;
  over_ = window_ = 0.0;
}

double HoldReserve::hold_time() const noexcept {
  return period_ + std::clamp(2.0 * std::max(over_, over_before_), 0.0, period_);
}

}  // namespace feltwire
