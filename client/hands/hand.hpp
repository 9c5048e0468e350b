#pragma once
// The arm behind a simulated hand.

namespace feltwire {

/// The arm behind the hand: a mass that moves with the device, and a spring and damper towards the
/// intended place.
struct Hand {
  double mass = 0.1;         // [kg]
  double damping = 5.0;      // [N s/m]
  double stiffness = 300.0;  // [N/m]
  // The wrist, about every axis: equal to the arm's values at a lever of kWristArm.
  double inertia = 1.6e-4;            // [kg m^2]
  double rotational_damping = 8e-3;   // [N m s/rad]
  double rotational_stiffness = 0.5;  // [N m/rad]
};
/// [m] the lever at which a wrist turns a tool.
inline constexpr double kWristArm = 0.04;
/// Returns the hand with a wrist that has its mass, damping and stiffness at that lever.
Hand with_wrist(Hand hand);
/// The parameters of a device that nobody holds.
inline constexpr Hand kNoHand = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

}  // namespace feltwire
