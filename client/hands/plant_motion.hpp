#pragma once
// The motion of a plant in continuous time: motor, transmission, handle, pad, hand.

#include <array>
#include <cstdint>
#include <vector>

#include "client/hands/amplifier.hpp"
#include "client/hands/plant.hpp"

namespace feltwire {

/// [J] The energies that flowed since the motion began.
struct PlantFlow {
  double given = 0.0;    // by the motor: the integral of its true force times its velocity
  double burned = 0.0;   // by the viscous and dry friction of the motor
  double to_hand = 0.0;  // by the handle to what holds it: pad, or else the hand's mass and arm
  double by_arm = 0.0;   // by the hand's muscles: intended movement, reflexes, changes of grip
  double lost = 0.0;     // by the dampers of transmission, pad and arm
};

/// Translation of one plant, axis by axis:
///
///   m_m x_m'' = f - B x_m' - F_dry(x_m') - F_t          motor: true force f, friction
///   m_h x_h'' = F_t - F_p                               handle: F_t through the transmission
///   m   x''   = F_p + k (x_i - x) + b (x_i' - x') + F_r  hand: F_p through the pad, its reflexes
///   F_r
///
/// Bodies with a rigid part between them are one body. Implicit midpoint rule, where the forces of
/// springs are those of their energy between both ends of the step: given + by_arm equals the
/// change of stored() + burned + lost up to rounding. The dry friction of a step stops the motor,
/// and never turns it round.
///
/// Deterministic: the same calls give the same bits. Nothing allocates after construction.
class PlantMotion {
 public:
  /// `hand` is used as it is; see held_by(). Throws PlantError, also where a part swings too fast
  /// to be computed.
  PlantMotion(const Plant& plant, const DeviceSpec& spec, const Hand& hand);

  /// Puts all bodies here, at rest, with the backlash in its middle [m].
  void place(const Vec3& position) noexcept;
  /// The force [N] on the hand was written at `time` [s] since the beginning.
  void write(double time, const Vec3& force) noexcept { amplifier_.write(time, force); }
  /// [s] the longest step().
  double longest_step() const noexcept { return longest_step_; }
  /// Moves from `begin` on by `span` [s]. The arm intends `intended` [m] at the beginning, and
  /// moves it at `velocity` [m/s].
  void step(double begin, double span, const Vec3& intended, const Vec3& velocity) noexcept;
  /// [m] The position that the encoder measures, with its noise, before its quantum.
  Vec3 measured() noexcept;

  const Vec3& motor_position() const noexcept { return position_[kMotor]; }     // [m]
  const Vec3& motor_velocity() const noexcept { return velocity_[kMotor]; }     // [m/s]
  const Vec3& handle_position() const noexcept { return position_[handle_]; }   // [m]
  const Vec3& handle_velocity() const noexcept { return velocity_[handle_]; }   // [m/s]
  const Vec3& hand_position() const noexcept { return position_[hand_body_]; }  // [m]
  const Vec3& motor_force() const noexcept { return amplifier_.output(); }      // [N] true, now
  const PlantFlow& flow() const noexcept { return flow_; }
  /// [J] in masses and springs now.
  double stored() const noexcept;

 private:
  static constexpr std::size_t kMotor = 0, kBodies = 3;
  using Bodies = std::array<Vec3, kBodies>;
  /// The forces over one step.
  struct Forces {
    Vec3 transmission = Vec3::Zero(), transmission_spring = Vec3::Zero();  // on the handle
    Vec3 pad = Vec3::Zero();                                               // on the hand
    Vec3 arm = Vec3::Zero();                                               // on the hand
    Vec3 dry = Vec3::Zero();                                               // on the motor
  };
  struct Drive {
    double step;
    Vec3 motor, reflex;        // [N]
    Vec3 error, intended_way;  // [m] of the arm at the beginning; that the arm intends
    double grip_before, grip_after;
    double grip() const noexcept { return 0.5 * (grip_before + grip_after); }
  };
  double grip(double time) const noexcept;
  Vec3 reflex(double time) noexcept;
  void remember(double time, const Vec3& error, const Vec3& rate) noexcept;
  void strain_transmission(const Bodies& moved, double span, Forces& forces) const noexcept;
  Forces forces(const Bodies& moved, const Drive& drive) const noexcept;
  Bodies accelerated(Forces& forces, const Bodies& moved, const Drive& drive,
                     const Vec3& most_dry) const noexcept;
  Vec3 most_dry_friction() const noexcept;
  void count(const Forces& forces, const Bodies& moved, const Bodies& velocity,
             const Drive& drive) noexcept;
  double spring_energy(double share, const Vec3& error) const noexcept;

  Plant plant_;
  Damping damping_;
  double dry_;  // [N]
  Hand arm_;
  bool pad_;  // there is one
  std::size_t handle_, hand_body_, count_;
  std::array<double, kBodies> mass_{};  // [kg]
  double longest_step_;
  Amplifier amplifier_;
  Bodies position_{}, velocity_{};
  Vec3 arm_error_ = Vec3::Zero();  // [m] intended minus true
  double share_ = 1.0;             // of the grip now
  PlantFlow flow_;
  std::uint64_t noises_ = 0;

  /// The error of the arm, one every kMemoryStep.
  struct Error {
    Vec3 way, rate;
  };
  static constexpr double kMemoryStep = 1e-4;  // [s]
  std::vector<Error> memory_;                  // a ring; empty: there is no reflex
  std::uint64_t remembered_ = 0;               // number of them so far
};

}  // namespace feltwire
