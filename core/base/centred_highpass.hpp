#pragma once
// The fast part of a signal: the measure of oscillation, the same for the lab and the client.

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace feltwire {

/// The window of the high-pass for oscillations [s].
inline constexpr double kOscillationWindow = 0.051;

/// An odd number of samples, as near as possible to `time` [s] at `rate` [Hz]; at least 3.
inline std::size_t odd_window(double time, double rate) {
  const auto half = static_cast<std::size_t>(std::llround(0.5 * (time * rate - 1.0)));
  return 2 * (half > 0 ? half : 1) + 1;
}

/// y(n) = mean(x(n-h) ... x(n+h)) - x(n): a centred moving average of 2 h + 1 values less the
/// middle value. Of a sinusoid of f [Hz] sampled every T it keeps the share
///   |1 - sin(pi f W T) / (W sin(pi f T))|,  W = 2 h + 1,
/// and nothing of a value that rises evenly. It allocates only when it is made. A value costs the
/// same for every W; only at every W-th value the sum is computed anew, so that rounding does not
/// accumulate.
class CentredHighPass {
 public:
  /// `window` W, odd, at least 3.
  explicit CentredHighPass(std::size_t window) : ring_(window) {}

  /// Takes the next value. Returns y of the value W / 2 before it, or nothing until W values have
  /// come.
  std::optional<double> push(double value) noexcept {
    const std::size_t window = ring_.size();
    if (known_ < window) {
      ring_[known_++] = value;
      if (known_ < window) return std::nullopt;
      sum_anew();
    } else {
      sum_ += value - ring_[at_];
      ring_[at_] = value;
      if (++at_ == window) {
        at_ = 0;
        sum_anew();
      }
    }
    std::size_t middle = at_ + window / 2;
    if (middle >= window) middle -= window;
    return sum_ / static_cast<double>(window) - (ring_[middle] - origin_);
  }

  /// Forgets all values.
  void begin_anew() noexcept { known_ = at_ = 0; }

 private:
  /// Sums differences to one of the values, so that a distant origin costs no digits.
  void sum_anew() noexcept {
    origin_ = ring_[ring_.size() / 2];
    sum_ = 0.0;
    for (const double value : ring_) sum_ += value - origin_;
  }

  std::vector<double> ring_;
  std::size_t known_ = 0, at_ = 0;  // values; place of the oldest
  double origin_ = 0.0, sum_ = 0.0;
};

}  // namespace feltwire
