#include "core/bounding/hand_force_bound.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {

void HandForceBound::moved(const Vec3& displacement, const Vec3& held, double hold_time) noexcept {
  pass(hold_time);
  // The weights of the held forces are valid only for samples of about one period.
  if (hold_time < 0.5 * period_ || hold_time > 1.5 * period_) return forget();
  const double late = (block_.samples + 0.5) / kSamples;
  block_.way += displacement;
  block_.rising += late * held;
  block_.falling += (1.0 - late) * held;
  if (++block_.samples < kSamples) return;
  if (known_before_) look();
  begin(block_, true);
}

void HandForceBound::look() noexcept {
  const double block_time = kSamples * period_;
  const double per_metre = mass_ / (block_time * block_time);
  const Vec3 force = per_metre * (block_.way - before_.way) -
                     (before_.rising + block_.falling) / static_cast<double>(kSamples);
  const double most_axes = std::sqrt(3.0);  // largest |u|_1 of a unit vector
  largest_ = std::max(largest_, length(force) + 2.0 * most_axes * per_metre * quantum_);
}

void HandForceBound::pass(double time) noexcept {
  time_ += time;
  // The half period allows for rounding errors of the sum.
  if (time_ < kWindow - 0.5 * period_) return;
  const double seen = kMargin * std::max(largest_, largest_before_);
  bound_ = std::clamp(seen, kLeastShare * told_, told_);
  largest_before_ = largest_;
  largest_ = 0.0;
  time_ = 0.0;
}

void HandForceBound::exceeded() noexcept {
  bound_ = largest_before_ = told_;
  largest_ = 0.0;
  time_ = 0.0;
}

}  // namespace feltwire
