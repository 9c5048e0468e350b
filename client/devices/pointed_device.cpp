#include "client/devices/pointed_device.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kYielding = 0.05;  // [m/s] of where a hand means to be that was pushed away

/// As long as `most` at most, in the same direction.
Vec3 shortened(const Vec3& v, double most) noexcept {
  const double length = v.norm();
  return length > most ? Vec3(v * (most / length)) : v;
}

}  // namespace

PointedDevice::PointedDevice(const PointedHandOptions& options, Ring<Pointing>& pointings)
    : HandDevice(options.spec, options.hand), options_(options), pointings_(pointings) {
  const auto usable = [](double v) { return std::isfinite(v) && v > 0.0; };
  for (const double number : {options.speed, options.reach, options.smoothing, options.patience,
                              options.beginning, options.clearance})
    if (!usable(number))
      throw std::invalid_argument("each number of a pointed hand must be finite and above zero");
}

void PointedDevice::begin(const Vec3& position, const Vec3& normal) {
  start_ = target_ = aim_ = position + options_.clearance * normal.normalized();
  place(start_);
}

DeviceReading PointedDevice::read(Nanoseconds now) noexcept {
  if (!started_) began_ = heard_ = now;
  started_ = true;
  Pointing told;
  while (pointings_.pop(told)) {
    heard_ = now;
    if (told.kind == Pointing::Kind::let_go) ended_ = true;
    // One that is not finite is no place; the hand stays with the last.
    if (told.kind == Pointing::Kind::to && told.target.allFinite()) target_ = told.target;
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

Vec3 PointedDevice::intended(double time) noexcept {
  const double elapsed = time - aimed_at_;
  aimed_at_ = time;
  const Vec3 way = (1.0 - std::exp(-elapsed / options_.smoothing)) * (target_ - aim_);
  // The spring grows no longer than its reach. Where the hand is pushed away from where it means to
  // be, that stays: it would else move with the hand, and the arm would damp nothing.
  const Vec3& hand = true_position();
  const double most = std::max(options_.reach, (aim_ - hand).norm() - kYielding * elapsed);
  aim_ = hand + shortened(aim_ + shortened(way, options_.speed * elapsed) - hand, most);
  return aim_;
}

}  // namespace feltwire
