#include "client/devices/hand_device.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace feltwire {
namespace {

constexpr double kLongestStep = 20e-6;  // [s]

}  // namespace

HandDevice::HandDevice(const DeviceSpec& spec, const Hand& hand) : spec_(spec), hand_(hand) {
  validate(spec_);
  const auto usable = [](double v) { return std::isfinite(v) && v >= 0.0; };
  if (!usable(hand.mass) || !usable(hand.damping) || !usable(hand.stiffness))
    throw std::invalid_argument(
        "the hand's mass, damping and stiffness must be finite and not negative");
  if (!(spec_.apparent_mass + hand.mass > 0.0))
    throw std::invalid_argument("device and hand together must have a mass above zero [kg]");
}

void HandDevice::place(const Vec3& position) noexcept {
  intended_ = position_ = position;
  if (spec_.translation_dof == 2) intended_.z() = position_.z() = 0.0;
}

DeviceReading HandDevice::read(Nanoseconds now) noexcept {
  if (!started_) {
    started_ = true;
    start_ = now;
  }
  integrate(std::chrono::duration<double>(now - start_).count());
  DeviceReading reading;
  const double quantum = spec_.position_resolution;
  for (int i = 0; i < 3; ++i)
    reading.pose.position[i] =
        quantum > 0.0 ? std::round(position_[i] / quantum) * quantum : position_[i];
  return reading;
}

Command HandDevice::write(const Command& on_hand) noexcept {
  Command held = actuated(spec_, on_hand);
  if (released_.load() || !held.finite())
    held = {};  // an amplifier that gets nonsense gives nothing
  const double magnitude = held.force().norm();
  const double limit = spec_.max_force;
  if (limit > 0.0 && magnitude > limit) {
    held.elastic *= limit / magnitude;
    held.frictional *= limit / magnitude;
  }
  force_ = held.force();
  return held;
}

void HandDevice::integrate(double until) noexcept {
  const double span = until - time_;
  if (!(span > 0.0)) return;
  if (released_.load()) force_ = Vec3::Zero();
  const int steps = std::max(1, static_cast<int>(std::ceil(span / kLongestStep)));
  const double h = span / steps;

  // Within one reading the intended motion is straight: it has nothing above some 12 Hz.
  Vec3 target = intended(until);
  if (spec_.translation_dof == 2) target.z() = 0.0;
  const Vec3 intended_velocity = (target - intended_) / span;

  const double mass = spec_.apparent_mass + hand_.mass;
  Damping damping = spec_.damping;
  damping += hand_.damping;
  const double scale = 1.0 / (1.0 + h / mass * damping.least());
  const Mat3 solve = (Mat3::Identity() + h / mass * damping.matrix()).inverse();
  const double friction_impulse = spec_.coulomb_friction * h / mass;  // [m/s] at most, a step
  for (int i = 0; i < steps; ++i) {
    intended_ += h * intended_velocity;
    const Vec3 pull =
        hand_.stiffness * (intended_ - position_) + hand_.damping * intended_velocity + force_;
    const Vec3 driven = velocity_ + h / mass * pull;
    velocity_ = damping.isotropic() ? Vec3(scale * driven) : Vec3(solve * driven);
    for (double& v : velocity_)
      v = std::abs(v) > friction_impulse ? v - std::copysign(friction_impulse, v) : 0.0;
    position_ += h * velocity_;
  }
  intended_ = target;
  time_ = until;
}

}  // namespace feltwire
