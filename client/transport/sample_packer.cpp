#include "client/transport/sample_packer.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "protocol/session/deadband.hpp"
#include "protocol/session/slowest_pace.hpp"

namespace feltwire {

SamplePacker::SamplePacker(const SessionParameters& parameters, bool rotation,
                           const PositionScale& scale)
    : parameters_(parameters),
      scale_(scale),
      most_(parameters.batch + parameters.redundancy),
      recent_(parameters.batch > 1 ? static_cast<std::size_t>(parameters.packet_interval) : 1) {
  batch_.rotation = rotation;
}

bool SamplePacker::carry_fewer() noexcept {
  if (most_ == 1) return false;
  --most_;
  return true;
}

void SamplePacker::set_pace(int pace) noexcept {
  pace_ = std::clamp(pace, 1, slowest_pace(parameters_));
}

void SamplePacker::restart() noexcept {
  pace_ = 1;
  most_ = parameters_.batch + parameters_.redundancy;
  travelled_count_ = 0;
  fed_ = fed_at_last_ = 0;
  velocity_ = angular_velocity_ = Vec3::Zero();
}

const Sample& SamplePacker::recent(std::uint64_t ago) const noexcept {
  return recent_[(fed_ - 1 - ago) % recent_.size()];
}

const SampleBatch* SamplePacker::add(const Sample& sample, const std::optional<HandReport>& report,
                                     const std::optional<Lead>& lead) noexcept {
  recent_[fed_ % recent_.size()] = sample;
  ++fed_;
  const bool switched = lead && batch_.lead &&
                        (lead->deadman != batch_.lead->deadman || lead->seat != batch_.lead->seat);
  if (!switched && !due(sample)) return nullptr;
  const std::uint64_t interval = static_cast<std::uint64_t>(parameters_.packet_interval);
  if (travelled_count_ > 0) {
    const Sample& before = travelled_[0];
    const double elapsed = seconds(sample.client_time - before.client_time);
    if (elapsed > 0.0) {
      velocity_ = (sample.pose.position - before.pose.position) / elapsed;
      angular_velocity_ =
          rotation_between(before.pose.orientation, sample.pose.orientation) / elapsed;
    }
  }
  make(std::min(interval, fed_ - fed_at_last_));
  fed_at_last_ = fed_;
  batch_.report = report;
  batch_.lead = lead;
  return &batch_;
}

bool SamplePacker::due(const Sample& sample) const noexcept {
  if (travelled_count_ == 0) return true;
  const auto interval =
      static_cast<std::uint64_t>(pace_) * static_cast<std::uint64_t>(parameters_.packet_interval);
  if (fed_ - fed_at_last_ < interval) return false;
  return !(parameters_.position_deadband > 0.0) || !known(sample);
}

/// Returns whether the deadband allows the client to omit this sample.
bool SamplePacker::known(const Sample& sample) const noexcept {
  const Sample& last = travelled_[0];
  const double silence = seconds(sample.client_time - last.client_time);
  // Send the sample if the next tick would exceed the keep-alive time. Half a period allows for
  // jitter.
  if (!(silence + 0.5 * parameters_.servo_period < parameters_.keep_alive) || silence < 0.0)
    return false;
  if (acts(sample.held) != acts(last.held)) return false;

  const bool linear = parameters_.predictor == Predictor::linear;
  const double k = parameters_.position_deadband;
  const double force = length(sample.held.force());
  const double scale = force > 0.0 && scale_.stiffness > 0.0 ? force / scale_.stiffness
                                                             : kFreeAge * velocity_.norm();
  // Rounding may change the difference of two positions by a quantum.
  constexpr double kRounding = 1.0 + 1e-6;
  const double allowed = std::max(kRounding * scale_.quantum, k * scale);
  const Vec3 expected =
      linear ? Vec3(last.pose.position + silence * velocity_) : last.pose.position;
  if (beyond_deadband(sample.pose.position, expected, 0.0, allowed)) return false;
  if (!batch_.rotation) return true;
  Vec3 turned = rotation_between(last.pose.orientation, sample.pose.orientation);
  if (linear) turned -= silence * angular_velocity_;
  return !beyond_deadband(turned, Vec3::Zero(), 0.0,
                          std::max(kUnfeltAngle, k * kFreeAge * angular_velocity_.norm()));
}

/// Builds a datagram from the newest `fresh` samples and some repeated samples.
void SamplePacker::make(std::uint64_t fresh) noexcept {
  const std::uint64_t count =
      std::min({static_cast<std::uint64_t>(std::min(parameters_.batch, most_)), fresh,
                static_cast<std::uint64_t>(recent_.size())});
  const auto made = static_cast<int>(count);
  for (std::uint64_t i = 0; i < count; ++i) batch_.samples[i] = recent(i * fresh / count);
  const int again = std::min({travelled_count_, parameters_.redundancy, most_ - made});
  std::copy_n(travelled_.begin(), again, batch_.samples.begin() + made);
  batch_.count = made + again;
  batch_.previous =
      again < travelled_count_ ? travelled_[static_cast<std::size_t>(again)].index : 0;

  // The next datagram repeats `redundancy` samples and names the sample before them, so keep one
  // more.
  const int kept = parameters_.redundancy + 1;
  const int fresh_kept = std::min(made, kept);
  const int old_kept = std::min(travelled_count_, kept - fresh_kept);
  std::copy_backward(travelled_.begin(), travelled_.begin() + old_kept,
                     travelled_.begin() + fresh_kept + old_kept);
  std::copy_n(batch_.samples.begin(), fresh_kept, travelled_.begin());
  travelled_count_ = fresh_kept + old_kept;
}

}  // namespace feltwire
