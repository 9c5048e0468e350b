#pragma once
// A free handle with effects that make a device hard to measure. Its losses are known.

#include <cmath>
#include <deque>
#include <numbers>
#include <random>

#include "client/hands/amplifier.hpp"
#include "core/base/types.hpp"

namespace feltwire::identify_test {

struct HandleTruth {
  Mat3 damping = 0.5 * Mat3::Identity();            // [N s/m]
  Vec3 friction = Vec3::Constant(0.1);              // [N] of each axis, in motion
  Vec3 mass = Vec3::Constant(0.1);                  // [kg] of each axis
  double stiction = 0.0;                            // [N] extra at rest
  double stiction_speed = 0.01;                     // [m/s] at which it fades
  Vec3 gravity = Vec3::Zero();                      // [N] not compensated
  double cogging = 0.0;                             // [N] amplitude
  double cogging_pitch = 2e-3;                      // [m]
  double quantum = 0.0, noise = 0.0;                // [m]
  int force_delay = 0, reading_delay = 0;           // [ticks]
  double hand_stiffness = 0.0, hand_damping = 0.0;  // [N/m], [N s/m] of a person who holds it
  double servo_damping = 0.0;    // [N s/m] extra on axes with a force: a maker's filter
  Plant::Amplifier amplifier{};  // between the force and the motor
  // Between motor and handle; 0: rigid. The motor has the friction and the rest of the mass.
  double transmission = 0.0, transmission_damping = 0.0;  // [N/m], [N s/m]
  double handle_share = 0.0;                              // of the mass, behind the transmission
  bool encoder_at_handle = false;
  unsigned seed = 1;
};

class SimulatedHandle {
 public:
  explicit SimulatedHandle(const HandleTruth& truth)
      : truth_(truth), random_(truth.seed), amplifier_(truth.amplifier, truth.seed) {}

  /// The reading of the device now.
  Vec3 read() {
    readings_.push_back(truth_.encoder_at_handle ? handle_ : position_);
    if (readings_.size() > static_cast<std::size_t>(truth_.reading_delay) + 1)
      readings_.pop_front();
    Vec3 sensed = readings_.front();
    for (double& x : sensed) {
      if (truth_.noise > 0.0) x += truth_.noise * normal_(random_);
      if (truth_.quantum > 0.0) x = std::round(x / truth_.quantum) * truth_.quantum;
    }
    return sensed;
  }

  /// Holds the force for `period` [s].
  void hold(const Vec3& force, double period) {
    forces_.push_back(force);
    if (forces_.size() > static_cast<std::size_t>(truth_.force_delay) + 1) forces_.pop_front();
    amplifier_.write(now_, forces_.front());
    const int steps = truth_.transmission > 0.0 ? 20 : 4;
    for (int n = 0; n < steps; ++n, now_ += period / steps)
      advance(amplifier_.mean(now_, period / steps), period / steps);
  }

 private:
  void advance(const Vec3& force, double h) {
    Vec3 drag = truth_.damping * velocity_;
    for (int i = 0; i < 3; ++i)
      if (force[i] != 0.0) drag[i] += truth_.servo_damping * velocity_[i];
    for (int i = 0; i < 3; ++i) {
      const double turn = 2.0 * std::numbers::pi / truth_.cogging_pitch;
      const double midway = position_[i] + 0.5 * h * velocity_[i];
      const double outside =
          force[i] + truth_.gravity[i] + truth_.cogging * std::sin(turn * midway) -
          truth_.hand_stiffness * position_[i] - truth_.hand_damping * velocity_[i];
      const double link = truth_.transmission * (position_[i] - handle_[i]) +
                          truth_.transmission_damping * (velocity_[i] - handle_velocity_[i]);
      const double mass = (1.0 - truth_.handle_share) * truth_.mass[i];
      double v = velocity_[i] + h / mass * (outside - link - drag[i]);
      const double ratio = velocity_[i] / truth_.stiction_speed;
      const double most = truth_.friction[i] + truth_.stiction * std::exp(-ratio * ratio);
      const double stops = h / mass * most;
      v = std::abs(v) > stops ? v - std::copysign(stops, v) : 0.0;
      // Use the mean velocity: the work of the force then equals the change of the kinetic energy
      // plus the burned energy, and the integration burns nothing.
      position_[i] += 0.5 * h * (velocity_[i] + v);
      velocity_[i] = v;
      if (truth_.transmission == 0.0) continue;
      handle_velocity_[i] += h / (truth_.handle_share * truth_.mass[i]) * link;
      handle_[i] += h * handle_velocity_[i];
    }
  }

  HandleTruth truth_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  Vec3 position_ = Vec3::Zero(), velocity_ = Vec3::Zero();
  Vec3 handle_ = Vec3::Zero(), handle_velocity_ = Vec3::Zero();  // behind the transmission
  std::deque<Vec3> readings_, forces_;
  Amplifier amplifier_;
  double now_ = 0.0;  // [s]
};

}  // namespace feltwire::identify_test
