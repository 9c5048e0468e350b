#include "client/hands/hand_device.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace feltwire {
namespace {

constexpr double kLongestStep = 20e-6;  // [s] longest integration step

/// Applies dry friction: brings each component of a velocity closer to zero, by at most `most`.
void rub(Vec3& velocity, double most) noexcept {
  for (double& v : velocity) v = std::abs(v) > most ? v - std::copysign(most, v) : 0.0;
}

/// Implicit damping in a time step h: multiplies a velocity by (1 + h/m B)^-1, with the mass m and
/// the damping matrix B. The factor is `scale` for isotropic damping, else `solve`.
struct ImplicitDamping {
  ImplicitDamping(Damping device, double hand, double step_over_mass) {
    device += hand;
    isotropic = device.isotropic();
    scale = 1.0 / (1.0 + step_over_mass * device.least());
    solve = (Mat3::Identity() + step_over_mass * device.matrix()).inverse();
  }
  Vec3 operator()(const Vec3& driven) const noexcept {
    return isotropic ? Vec3(scale * driven) : Vec3(solve * driven);
  }
  bool isotropic;
  double scale;
  Mat3 solve;
};

/// Returns the factor, at most 1, that limits the length of `v` to `most`. 0 means no limit.
double share_within(const Vec3& v, double most) noexcept {
  const double length = v.norm();
  return most > 0.0 && length > most ? most / length : 1.0;
}

}  // namespace

Hand with_wrist(Hand hand) {
  constexpr double kSquared = kWristArm * kWristArm;
  hand.inertia = kSquared * hand.mass;
  hand.rotational_damping = kSquared * hand.damping;
  hand.rotational_stiffness = kSquared * hand.stiffness;
  return hand;
}

HandDevice::HandDevice(const DeviceSpec& spec, const Hand& given, const Plant& plant)
    : spec_(spec),
      hand_(held_by(plant, given)),
      turns_(spec.rotation_sensed > 0 && spec.rotation.inertia + hand_.inertia > 0.0) {
  validate(spec_);
  validate(plant, spec_);
  const Hand& hand = hand_;
  const auto usable = [](double v) { return std::isfinite(v) && v >= 0.0; };
  if (!usable(hand.mass) || !usable(hand.damping) || !usable(hand.stiffness) ||
      !usable(hand.inertia) || !usable(hand.rotational_damping) ||
      !usable(hand.rotational_stiffness))
    throw std::invalid_argument(
        "the hand's mass, inertia, damping and stiffness must be finite and not negative");
  if (!(spec_.apparent_mass + hand.mass > 0.0))
    throw std::invalid_argument("device and hand together must have a mass above zero [kg]");
  if (plant.ideal()) return;
  plant_.emplace(plant, spec_, hand_);
  Plant::Amplifier of_torque = plant.amplifier;
  of_torque.resolution = 0.0;  // the resolution applies to forces only
  torque_amplifier_.emplace(of_torque, plant.seed);
}

void HandDevice::place(const Vec3& position) noexcept {
  intended_ = position_ = position;
  if (spec_.translation_dof == 2) intended_.z() = position_.z() = 0.0;
  if (plant_) plant_->place(position_);
}

DeviceReading HandDevice::read(Nanoseconds now) noexcept {
  if (!started_) {
    started_ = true;
    start_ = now;
  }
  integrate(std::chrono::duration<double>(now - start_).count());
  DeviceReading reading;
  const double quantum = spec_.position_resolution;
  Vec3 measured = plant_ ? plant_->measured() : position_;
  // A device with two axes has no encoder along z.
  if (spec_.translation_dof == 2) measured.z() = position_.z();
  for (int i = 0; i < 3; ++i)
    reading.pose.position[i] =
        quantum > 0.0 ? std::round(measured[i] / quantum) * quantum : measured[i];
  if (turns_) reading.pose.orientation = measured_orientation();
  return reading;
}

/// Returns the orientation, rounded to the encoder resolution. Rotations about different axes do
/// not commute, so several rounds of rounding are necessary.
Quaternion HandDevice::measured_orientation() noexcept {
  const double quantum = spec_.rotation.resolution;
  if (!(quantum > 0.0)) return orientation_;
  constexpr int kRounds = 4;
  for (int i = 0; i < kRounds; ++i) {
    const Vec3 quanta = (rotation_between(measured_, orientation_) / quantum).array().round();
    if (quanta.isZero(0.0)) break;
    measured_ = turned(measured_, quantum * quanta);
  }
  return measured_;
}

Command HandDevice::write(const Command& on_hand) noexcept {
  Command held = actuated(spec_, on_hand);
  if (released_.load() || !held.finite())
    held = {};  // an amplifier gives no force for an invalid command
  const double share = share_within(held.force(), spec_.max_force);
  if (share < 1.0) {
    held.elastic *= share;
    held.frictional *= share;
  }
  held.torque *= share_within(held.torque, spec_.max_torque);
  force_ = held.force();
  torque_ = held.torque;
  if (plant_) {
    plant_->write(time_, force_);
    torque_amplifier_->write(time_, torque_);
  }
  return held;
}

void HandDevice::integrate(double until) noexcept {
  const double span = until - time_;
  if (!(span > 0.0)) return;
  if (released_.load()) {
    force_ = torque_ = Vec3::Zero();
    if (plant_) {
      plant_->write(time_, force_);
      torque_amplifier_->write(time_, torque_);
    }
  }
  const int steps = std::max(1, static_cast<int>(std::ceil(span / kLongestStep)));
  move(until, span, steps);
  if (turns_) turn(until, span, steps);
  look_at_energy();
  time_ = until;
}

void HandDevice::look_at_energy() noexcept {
  made_ = std::max(made_,
                   translation_.given + rotation_.given - translation_.burned - rotation_.burned);
}

TrueEnergy HandDevice::true_energy() const noexcept {
  TrueEnergy energy{.given = translation_.given + rotation_.given,
                    .burned = translation_.burned + rotation_.burned,
                    .made = made_};
  energy.to_hand = plant_ ? plant_->flow().to_hand
                          : translation_.given - translation_.burned -
                                0.5 * spec_.apparent_mass * velocity_.squaredNorm();
  return energy;
}

/// Integrates the translation. The intended motion has no content above 12 Hz, so linear
/// interpolation suffices.
void HandDevice::move(double until, double span, int steps) noexcept {
  const double h = span / steps;
  Vec3 target = intended(until);
  if (spec_.translation_dof == 2) target.z() = 0.0;
  if (plant_) return move_plant(target, span);
  const Vec3 intended_velocity = (target - intended_) / span;

  const double mass = spec_.apparent_mass + hand_.mass;
  const ImplicitDamping damped(spec_.damping, hand_.damping, h / mass);
  // [m/s] Largest velocity change by dry friction per step.
  const double friction_impulse = spec_.coulomb_friction * h / mass;
  for (int i = 0; i < steps; ++i) {
    intended_ += h * intended_velocity;
    const Vec3 pull =
        hand_.stiffness * (intended_ - position_) + hand_.damping * intended_velocity + force_;
    velocity_ = damped(velocity_ + h / mass * pull);
    rub(velocity_, friction_impulse);
    position_ += h * velocity_;
    translation_.given += h * force_.dot(velocity_);
    translation_.burned +=
        h * (spec_.damping.quadratic(velocity_) + spec_.coulomb_friction * velocity_.lpNorm<1>());
    if (!turns_) look_at_energy();
  }
  intended_ = target;
}

void HandDevice::move_plant(const Vec3& target, double span) noexcept {
  const Vec3 intended_velocity = (target - intended_) / span;
  const int steps = std::max(1, static_cast<int>(std::ceil(span / plant_->longest_step())));
  const double h = span / steps;
  for (int i = 0; i < steps; ++i) {
    plant_->step(time_ + i * h, h, intended_ + i * h * intended_velocity, intended_velocity);
    translation_ = {plant_->flow().given, plant_->flow().burned};
    if (!turns_) look_at_energy();
  }
  position_ = plant_->handle_position();
  velocity_ = plant_->handle_velocity();
  intended_ = target;
}

void HandDevice::turn(double until, double span, int steps) noexcept {
  const double h = span / steps;
  const Quaternion target = turned(Quaternion::Identity(), intended_turn(until));
  const Vec3 intended_velocity = rotation_between(intended_orientation_, target) / span;

  const double inertia = spec_.rotation.inertia + hand_.inertia;
  const ImplicitDamping damped(spec_.rotational_damping, hand_.rotational_damping, h / inertia);
  // [rad/s] Largest change of the angular velocity by dry friction per step.
  const double friction_impulse = spec_.rotation.friction * h / inertia;
  for (int i = 0; i < steps; ++i) {
    intended_orientation_ = turned(intended_orientation_, h * intended_velocity);
    const Vec3 torque = torque_amplifier_ ? torque_amplifier_->mean(time_ + i * h, h) : torque_;
    const Vec3 pull =
        hand_.rotational_stiffness * rotation_between(orientation_, intended_orientation_) +
        hand_.rotational_damping * intended_velocity + torque;
    angular_velocity_ = damped(angular_velocity_ + h / inertia * pull);
    rub(angular_velocity_, friction_impulse);
    orientation_ = turned(orientation_, h * angular_velocity_);
    rotation_.given += h * torque.dot(angular_velocity_);
    rotation_.burned += h * (spec_.rotational_damping.quadratic(angular_velocity_) +
                             spec_.rotation.friction * angular_velocity_.lpNorm<1>());
  }
  intended_orientation_ = target;
}

}  // namespace feltwire
