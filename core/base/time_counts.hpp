#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace feltwire {

/// Counts durations in few classes with fixed limits, for monitoring. Small (120 bytes) and exact;
/// use Histogram for quantiles. Recording neither allocates nor throws.
class TimeCounts {
 public:
  /// [ns] The longest time of each class except the last, which has all longer ones.
  static constexpr std::array<std::int64_t, 12> kLimits = {
      10'000,    20'000,    50'000,    100'000,    200'000,    500'000,
      1'000'000, 2'000'000, 5'000'000, 10'000'000, 50'000'000, 200'000'000};
  static constexpr std::size_t kClasses = kLimits.size() + 1;

  using Counts = std::array<std::uint64_t, kClasses>;

  TimeCounts() = default;
  /// Takes times that were counted elsewhere. `sum`: [ns] of all of them.
  TimeCounts(const Counts& counts, std::uint64_t sum) noexcept : counts_(counts), sum_(sum) {}

  /// Takes a time [ns] that occurred `times` times. A negative one counts as zero.
  void record(std::int64_t time, std::uint64_t times = 1) noexcept {
    const std::int64_t counted = std::max<std::int64_t>(time, 0);
    const auto found = std::lower_bound(kLimits.begin(), kLimits.end(), counted);
    counts_[static_cast<std::size_t>(found - kLimits.begin())] += times;
    sum_ += static_cast<std::uint64_t>(counted) * times;
  }

  const Counts& counts() const noexcept { return counts_; }
  std::uint64_t sum() const noexcept { return sum_; }  // [ns] of all times
  bool operator==(const TimeCounts&) const = default;

 private:
  Counts counts_{};
  std::uint64_t sum_ = 0;
};

}  // namespace feltwire
