#include "client/hands/amplifier.hpp"

#include <cmath>

#include "core/base/splitmix.hpp"

namespace feltwire {
namespace {

// Factor that maps the upper 53 bits of a random number to [0, 1).
constexpr double kUnit = 0x1p-53;

}  // namespace

Amplifier::Amplifier(const Plant::Amplifier& plant, std::uint64_t seed)
    : plant_(plant), seed_(seed), waiting_(kRoom) {}

void Amplifier::write(double time, const Vec3& written) noexcept {
  Vec3 vector = written;
  if (plant_.resolution > 0.0)
    vector = (written / plant_.resolution).array().round() * plant_.resolution;
  double arrives = time + plant_.delay;
  if (plant_.jitter > 0.0)
    arrives += plant_.jitter * kUnit * static_cast<double>(splitmix::draw(seed_, writes_++) >> 11U);
  // A newer force discards each waiting force that would arrive later.
  while (count_ > 0 && waiting(count_ - 1).arrives >= arrives) --count_;
  if (count_ == kRoom) {
    target_ = waiting(0).vector;
    first_ = (first_ + 1) % kRoom;
    --count_;
  }
  waiting(count_++) = {arrives, vector};
}

void Amplifier::take_arrived(double now) noexcept {
  while (count_ > 0 && waiting(0).arrives <= now) {
    target_ = waiting(0).vector;
    first_ = (first_ + 1) % kRoom;
    --count_;
  }
}

/// Returns the integral of the output over `span` [s] for a constant target. Sets output_ to the
/// output at the end of `span`.
Vec3 Amplifier::settle(double span) noexcept {
  if (!(plant_.lag > 0.0)) {
    output_ = target_;
    return span * target_;
  }
  if (span != span_) {
    span_ = span;
    left_ = std::exp(-span / plant_.lag);
  }
  const Vec3 missing = output_ - target_;
  output_ = target_ + left_ * missing;
  return span * target_ + plant_.lag * (1.0 - left_) * missing;
}

Vec3 Amplifier::mean(double begin, double span) noexcept {
  const double end = begin + span;
  take_arrived(begin);
  if (count_ == 0 || waiting(0).arrives >= end) return settle(span) / span;
  Vec3 integral = Vec3::Zero();
  double from = begin;
  while (count_ > 0 && waiting(0).arrives < end) {
    const double until = waiting(0).arrives;
    integral += settle(until - from);
    from = until;
    take_arrived(until);
  }
  integral += settle(end - from);
  return integral / span;
}

}  // namespace feltwire
