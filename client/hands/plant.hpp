#pragma once
// The plant of a simulated device: what a real one has between write() and the motor, between the
// motor and the handle, and between the handle and the arm of the hand.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "client/hands/hand.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// The numbers that a specification (DeviceSpec) does not have: mass, damping, dry friction,
/// encoder quantum and largest force are those of the device. The defaults are a rigid device
/// without lag, which a hand holds without a pad.
struct Plant {
  /// From write() to the motor: u(t) is the force that was written, rounded to the resolution;
  /// lag f' = u(t - delay - jitter) - f. A force that comes after a newer one is left out.
  struct Amplifier {
    double lag = 0.0;         // [s] time constant of a filter of first order
    double delay = 0.0;       // [s] pure delay
    double jitter = 0.0;      // [s] each force comes later by up to this, drawn evenly
    double resolution = 0.0;  // [N] step of the force along each axis; 0: none
  };
  /// From the motor to the handle: a spring with a damper beside it, along each axis. Within the
  /// backlash neither acts, and at its ends they only push.
  struct Transmission {
    double stiffness = std::numeric_limits<double>::infinity();  // [N/m] infinite: rigid
    double damping = 0.0;                                        // [N s/m]
    double backlash = 0.0;                                       // [m] full width
    double handle_mass = 0.0;  // [kg] of the device's apparent mass, behind the transmission

    bool rigid() const noexcept { return stiffness == std::numeric_limits<double>::infinity(); }
  };
  /// Dry friction of the motor at speed v along an axis:
  ///   f_c + (breakaway - f_c) exp(-(v / stribeck_velocity)^2),  f_c the device's dry friction
  struct Friction {
    double breakaway = 0.0;          // [N] at rest, at least f_c; 0: f_c at every speed
    double stribeck_velocity = 0.0;  // [m/s]
  };
  struct Encoder {
    EncoderSide side = EncoderSide::motor;
    double noise = 0.0;  // [m] RMS along each axis, normally distributed, before the quantum
  };
  /// The share of its stiffness and damping with which the hand grips from a time on. Between two
  /// of them the share goes in a straight line.
  struct Grip {
    double time = 0.0;  // [s] since the first reading
    double share = 1.0;
  };
  /// The hand beyond `Hand`. The pad of the finger stands between handle and hand. Reflexes pull
  /// like a second spring and damper of the arm, at the error of `reflex_delay` ago.
  struct HeldHand {
    std::optional<double> mass{}, damping{},
        stiffness{};  // [kg], [N s/m], [N/m] instead of the Hand's
    double pad_stiffness = std::numeric_limits<double>::infinity();  // [N/m] infinite: no pad
    double pad_damping = 0.0;                                        // [N s/m]
    double reflex_delay = 0.0;                                       // [s]
    double reflex_stiffness = 0.0;                                   // [N/m]
    double reflex_damping = 0.0;                                     // [N s/m]
    std::vector<Grip> grip{};  // times rise; before the first and after the last it is constant

    bool has_pad() const noexcept {
      return pad_stiffness < std::numeric_limits<double>::infinity();
    }
    bool has_reflex() const noexcept { return reflex_stiffness > 0.0 || reflex_damping > 0.0; }
  };

  std::string name{};
  Amplifier amplifier{};
  Transmission transmission{};
  Friction friction{};
  Encoder encoder{};
  HeldHand hand{};
  std::uint64_t seed = 1;  // of jitter and noise

  /// Whether it is the ideal device: the force that is written is at the motor at once; motor,
  /// handle and hand are one body; its encoder has no noise.
  bool ideal() const noexcept;
};

/// A number of a plant that is not finite, negative or contradictory: what() names the field and
/// the remedy.
struct PlantError : std::invalid_argument {
  PlantError(std::string in_field, std::string says)
      : std::invalid_argument("the plant's " + in_field + ": " + says),
        field(std::move(in_field)),
        why(std::move(says)) {}
  std::string field, why;  // the field as a path: "amplifier.lag"
};

/// Throws PlantError.
void validate(const Plant& plant);
/// Checks it together with its device. Throws PlantError.
void validate(const Plant& plant, const DeviceSpec& spec);

/// The hand with the numbers that the plant has instead, and then with the wrist of its arm.
Hand held_by(const Plant& plant, Hand hand);

}  // namespace feltwire
