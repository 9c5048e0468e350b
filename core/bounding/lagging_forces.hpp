#pragma once
// The forces of a motor that follows its commands with a lag.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/base/types.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// How a motor follows its commands.
struct MotorLag {
  /// `delay`: the true force is at each time a mean of the commands of the last L, as of a filter
  /// with a non-negative impulse response, a gain of 1, and no response after L. That is a delay of
  /// at most L, whether or not it varies; a mean over a time; or one after the other, L in all.
  /// `filter`: a first-order lag with a time constant of at most L. Its response later than kRest
  /// L, which is 0.25 % of a force, counts as nothing.
  /// `mixed`: a delay of d and then a first-order lag of at most L - d, whatever d is. The share of
  /// its older forces is largest for d = 0 or d = L (docs/bounding.md).
  static constexpr double kRest = 6.0;

  double time = 0.0;  // L [s] an upper bound
  LagKind kind = LagKind::delay;

  /// [s] the age at which a force acts no longer.
  double rest() const noexcept { return kind == LagKind::delay ? time : kRest * time; }
};

/// The older forces of one port that its motor may still hold a part of.
class LaggingForces {
 public:
  /// The periods that MotorLag::rest() can last. Room for a sample that was short comes on top.
  static constexpr int kMostSamples = 6;
  static constexpr std::size_t kMost = kMostSamples + 2;

  /// An older force. `age` [s]: the time from the end of its sample to the beginning of this one.
  struct Older {
    Vec3 force = Vec3::Zero();
    double age = 0.0;
  };

  explicit LaggingForces(const MotorLag& lag = {}) : lag_(lag) {}

  const MotorLag& lag() const noexcept { return lag_; }
  /// At least 1.
  std::size_t count() const noexcept { return count_; }
  /// From the newest on.
  const Older& operator[](std::size_t i) const noexcept { return older_[i]; }

  /// The most that a force of this age, with all that are older, can make up of the mean force over
  /// a sample of `time` [s] that begins `ahead` [s] after the present one.
  double share(double age, double ahead, double time) const noexcept {
    const double begins = age + ahead, left = lag_.rest() - begins;
    if (!(left > 0.0)) return 0.0;
    const double of_delay = std::clamp((lag_.time - begins) / time, 0.0, 1.0);
    if (lag_.kind == LagKind::delay) return of_delay;
    const double of_filter =
        lag_.time / time * std::exp(-begins / lag_.time) * -std::expm1(-time / lag_.time);
    return lag_.kind == LagKind::filter ? of_filter : std::max(of_delay, of_filter);
  }
  /// [N] the largest.
  double strongest() const noexcept {
    double squared = 0.0;
    for (std::size_t i = 0; i < count_; ++i)
      squared = std::max(squared, older_[i].force.squaredNorm());
    return std::sqrt(squared);
  }
  bool nothing() const noexcept {
    return std::all_of(older_.begin(), older_.begin() + static_cast<std::ptrdiff_t>(count_),
                       [](const Older& one) { return one.force.isZero(0.0); });
  }

  /// The sample in which `held` was commanded is over; it lasted `time` [s]. If there are more
  /// forces than room, which samples far below a period make, the two oldest count as the stronger
  /// of them.
  void passed(const Vec3& held, double time) noexcept {
    const double since = std::isfinite(time) ? std::max(time, 0.0) : 0.0;
    for (std::size_t i = 0; i < count_; ++i) older_[i].age += since;
    while (count_ > 0 && older_[count_ - 1].age >= lag_.rest()) --count_;
    if (!(lag_.time > 0.0)) return;
    if (count_ == older_.size()) {
      Older &last = older_[count_ - 1], &before = older_[count_ - 2];
      if (before.force.squaredNorm() > last.force.squaredNorm()) last.force = before.force;
      last.age = before.age;
      older_[count_ - 2] = last;
      --count_;
    }
    std::shift_right(older_.begin(), older_.begin() + static_cast<std::ptrdiff_t>(count_) + 1, 1);
    older_.front() = {held, 0.0};
    ++count_;
  }
  /// Nothing was commanded before.
  void forget() noexcept {
    count_ = 1;
    older_.front() = {};
  }

 private:
  MotorLag lag_;
  std::array<Older, kMost> older_{};
  std::size_t count_ = 1;  // nothing was commanded at first
};

}  // namespace feltwire
