#include "client/servo/feel_metrics.hpp"

#include <cmath>

#include "client/servo/zero_force_reason.hpp"
#include "core/base/numeric.hpp"

namespace feltwire {

FeelMetrics::FeelMetrics(double period)
    : period_(period),
      axes_{CentredHighPass(odd_window(kOscillationWindow, 1.0 / period)),
            CentredHighPass(odd_window(kOscillationWindow, 1.0 / period)),
            CentredHighPass(odd_window(kOscillationWindow, 1.0 / period))} {}

void FeelMetrics::take(const Vec3& displacement, const Vec3& elastic, const Vec3& held) noexcept {
  const double asked = length(elastic);
  const bool touches = asked >= kFeltForce;
  if (!touches && !in_contact_) return;
  if (touches) normal_ = direction(elastic);
  if (!in_contact_) {
    in_contact_ = true;
    way_ = Vec3::Zero();  // the contact starts at this tick
  } else {
    way_ += displacement;
    depth_ -= displacement.dot(normal_);
  }
  Vec3 fast = Vec3::Zero();
  bool full = false;
  for (int i = 0; i < 3; ++i) {
    const auto value = axes_[static_cast<std::size_t>(i)].push(way_[i]);
    full = value.has_value();
    fast[i] = value.value_or(0.0);
  }
  if (full) {
    const double along = fast.dot(normal_);
    pending_.sum += along * along;
    ++pending_.count;
  }
  if (touches) {
    squares_.sum += pending_.sum;
    squares_.count += pending_.count;
    pending_ = {};
    without_force_ = 0.0;
    press(displacement, held);
    return;
  }
  without_force_ += period_;
  if (without_force_ >= 0.5 * kOscillationWindow) end_contact();
}

void FeelMetrics::press(const Vec3& displacement, const Vec3& held) noexcept {
  const double inwards = -displacement.dot(normal_), force = held.dot(normal_);
  const bool deeper = depth_ > deepest_;
  deepest_ = std::max(deepest_, depth_);
  if (!deeper || force < kFeltForce || 2.0 * inwards * inwards < displacement.squaredNorm()) return;
  // mean_depth_ and mean_force_ are means over this contact (Welford's method). depth_depth_ and
  // depth_force_ are sums over all contacts.
  ticks_ += 1.0;
  const double from_mean = depth_ - mean_depth_;
  mean_depth_ += from_mean / ticks_;
  mean_force_ += (force - mean_force_) / ticks_;
  all_ticks_ += 1.0;
  depth_depth_ += from_mean * (depth_ - mean_depth_);
  depth_force_ += from_mean * (force - mean_force_);
}

void FeelMetrics::end_contact() noexcept {
  if (!in_contact_) return;
  in_contact_ = false;
  pending_ = {};
  without_force_ = depth_ = deepest_ = ticks_ = mean_depth_ = mean_force_ = 0.0;
  for (CentredHighPass& axis : axes_) axis.begin_anew();
}

std::optional<double> FeelMetrics::Squares::rms() const {
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

std::optional<double> FeelMetrics::displayed_stiffness() const {
  constexpr double kTicks = 32.0, kSpread = 20e-6;  // least ticks and RMS spread of the depth [m]
  if (all_ticks_ < kTicks || depth_depth_ < all_ticks_ * kSpread * kSpread) return std::nullopt;
  return depth_force_ / depth_depth_;
}

}  // namespace feltwire
