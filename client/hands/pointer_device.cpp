#include "client/hands/pointer_device.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "client/hands/hand_aim.hpp"
#include "core/base/numeric.hpp"

namespace feltwire {
PointerDevice::PointerDevice(const PointerHandOptions& options, Ring<PointerMessage>& messages)
    : HandDevice(options.spec, options.hand), options_(options), messages_(messages) {
  const auto usable = [](double v) { return std::isfinite(v) && v > 0.0; };
  for (const double number : {options.speed, options.reach, options.smoothing, options.patience,
                              options.beginning, options.clearance})
    if (!usable(number))
      throw std::invalid_argument("each number of a pointed hand must be finite and above zero");
}

void PointerDevice::begin(const Vec3& position, const Vec3& normal) {
  start_ = target_ = aim_ = position + options_.clearance * normal.normalized();
  place(start_);
}

DeviceReading PointerDevice::read(Nanoseconds now) noexcept {
  if (!started_) began_ = heard_ = now;
  started_ = true;
  PointerMessage told;
  while (messages_.pop(told)) {
    heard_ = now;
    if (told.kind == PointerMessage::Kind::let_go) ended_ = true;
    // Ignore an invalid target. The hand stays at the last target.
    if (told.kind == PointerMessage::Kind::to && told.target.allFinite()) target_ = told.target;
  }
  if (!ended_ && now - heard_ > from_seconds(options_.patience) &&
      now - began_ > from_seconds(options_.beginning)) {
    ended_ = true;
    neglected_.store(true);
  }
  DeviceReading reading = HandDevice::read(now);
  reading.ended = ended_;
  return reading;
}

Vec3 PointerDevice::intended(double time) noexcept {
  const double elapsed = time - aimed_at_;
  aimed_at_ = time;
  const Vec3 way = (1.0 - std::exp(-elapsed / options_.smoothing)) * (target_ - aim_);
  const Vec3& hand = true_position();
  aim_ = hand + led(aim_ - hand, clamp_length(way, options_.speed * elapsed), options_.reach,
                    kYielding * elapsed);
  return aim_;
}

}  // namespace feltwire
