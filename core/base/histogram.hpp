#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace feltwire {

/// Log-linear histogram of whole numbers in the caller's unit: 128 buckets an octave, so that a
/// quantile is off by at most 1/256 of its value (0.4 %), and exact below 256. Values from 2^40 on
/// share the last bucket. The count, the sum and the maximum are exact. 35 kB; recording neither
/// allocates nor branches on data beyond one comparison. Source: the layout of HdrHistogram (G.
/// Tene), with two fixed significant digits.
class Histogram {
 public:
  void record(std::int64_t value) noexcept {
    const auto v = static_cast<std::uint64_t>(std::max<std::int64_t>(value, 0));
    ++counts_[bucket(std::min(v, kLimit - 1))];
    ++count_;
    sum_ += static_cast<double>(v);
    max_ = std::max(max_, v);
  }

  std::uint64_t count() const noexcept { return count_; }
  std::uint64_t max() const noexcept { return max_; }
  /// 0 when empty.
  double mean() const noexcept { return count_ > 0 ? sum_ / static_cast<double>(count_) : 0.0; }

  /// The smallest value that is not exceeded by at least the share q (0 to 1) of all values; 0 if
  /// the histogram is empty.
  double quantile(double q) const noexcept {
    if (count_ == 0) return 0.0;
    const double wanted = std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_));
    const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(wanted));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += counts_[i];
      if (seen >= rank) return std::min(middle(i), static_cast<double>(max_));
    }
    return static_cast<double>(max_);
  }

 private:
  static constexpr int kBits = 7;  // buckets an octave: 2^kBits
  static constexpr int kLimitBits = 40;
  static constexpr std::uint64_t kLimit = std::uint64_t{1} << kLimitBits;
  static constexpr std::size_t kBuckets = std::size_t{kLimitBits - kBits + 1} << kBits;

  /// Values below 2^(kBits+1) have a bucket each; above, the leading kBits + 1 bits choose it.
  static std::size_t bucket(std::uint64_t v) noexcept {
    const int octave = std::max(0, static_cast<int>(std::bit_width(v)) - (kBits + 1));
    return (static_cast<std::size_t>(octave) << kBits) + static_cast<std::size_t>(v >> octave);
  }
  static double middle(std::size_t bucket) noexcept {
    if (bucket < (std::size_t{2} << kBits)) return static_cast<double>(bucket);
    const std::size_t octave = (bucket >> kBits) - 1;
    const std::uint64_t lowest = static_cast<std::uint64_t>(bucket - (octave << kBits)) << octave;
    const std::uint64_t width = std::uint64_t{1} << octave;
    return static_cast<double>(lowest) + 0.5 * static_cast<double>(width - 1);
  }

  std::array<std::uint64_t, kBuckets> counts_{};
  std::uint64_t count_ = 0;
  double sum_ = 0.0;
  std::uint64_t max_ = 0;
};

}  // namespace feltwire
