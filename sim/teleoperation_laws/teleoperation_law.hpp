#pragma once
// The inputs and outputs of a bilateral teleoperation law of one degree of freedom, at both ends.

#include <cstdint>
#include <span>

namespace feltwire::teleop {

/// The hardware as a law knows it.
struct Plant {
  double period = 1e-3;              // T [s] of both servos
  double leader_damping = 0.5;       // b [N s/m] of the device, for certain
  double leader_mass = 0.05;         // [kg] of its handle
  double leader_quantum = 23e-6;     // [m] of its encoder
  double leader_force = 20.0;        // [N] its largest
  double hand_force = 10.0;          // F_h [N] the largest force of a hand on it
  double follower_damping = 2.0;     // b_f [N s/m] of the robot, for certain
  double follower_mass = 2.0;        // [kg]
  double stiffness = 1000.0;         // K_f [N/m] of the robot's own impedance controller
  double controller_damping = 60.0;  // B_f [N s/m] of it
  double wrench_noise = 0.035;       // [N] largest error of its force sensor
};

/// All values that a law may send; each uses some of them. Forces as F at the leader (resists the
/// hand).
struct Datagram {
  std::uint64_t index = 0;  // of the sender's servo sample
  double time = 0.0;        // [s] when it was sent; the clocks of both ends agree
  double position = 0.0, velocity = 0.0, force = 0.0;
  double wave = 0.0, wave_integral = 0.0;                // [sqrt W], [sqrt W s]
  double energy = 0.0, energy_back = 0.0, pushed = 0.0;  // [J] totals, by the law
  // The contact that the follower estimates, and the leader's knowledge of it.
  std::uint32_t surface = 0;
  bool touching = false;
  double place = 0.0, stiffness = 0.0, surface_velocity = 0.0;
};

struct LeaderSample {
  double time = 0.0;      // [s]
  double position = 0.0;  // [m] as the encoder reports
  double velocity = 0.0;  // [m/s] low-passed at 60 Hz
};
struct FollowerSample {
  double time = 0.0;
  double position = 0.0, velocity = 0.0;  // [m], [m/s] of the robot's tip
  double force = 0.0;                     // [N] on the robot, from its wrench sensor
};

/// The output of a robot's servo until the next sample: force + damping (reference - v). The damper
/// runs in the robot's own fast loop.
struct FollowerForce {
  double force = 0.0;      // [N]
  double damping = 0.0;    // [N s/m]
  double reference = 0.0;  // [m/s]
};

/// A law, both ends. The bench calls lead() and follow() once a sample each, with the datagrams
/// that arrived since the last one in the order of arrival, and `out` filled with index and time.
class TeleoperationLaw {
 public:
  TeleoperationLaw() = default;
  TeleoperationLaw(const TeleoperationLaw&) = delete;
  TeleoperationLaw& operator=(const TeleoperationLaw&) = delete;
  virtual ~TeleoperationLaw() = default;
  /// The force F [N] that resists the hand until the next sample.
  virtual double lead(const LeaderSample& sample, std::span<const Datagram> arrived,
                      Datagram& out) = 0;
  virtual FollowerForce follow(const FollowerSample& sample, std::span<const Datagram> arrived,
                               Datagram& out) = 0;
  /// [m] the robot's wanted place is the hand's place less this.
  virtual double offset() const { return 0.0; }
};

/// Keeps the newest message by index.
template <class Message>
class NewestOf {
 public:
  /// Returns whether one is newer than the known one.
  bool take(std::span<const Message> arrived) {
    bool newer = false;
    for (const Message& m : arrived) {
      if (known_ && m.index <= message_.index) continue;
      message_ = m;
      known_ = newer = true;
    }
    return newer;
  }
  bool known() const { return known_; }
  const Message* operator->() const { return &message_; }

 private:
  Message message_;
  bool known_ = false;
};
using Newest = NewestOf<Datagram>;

}  // namespace feltwire::teleop
