#pragma once
// The hands for judging a bound: one hand may be calm where another swings.

#include <array>
#include <optional>
#include <string_view>

#include "client/hands/simulated_device.hpp"

namespace feltwire {

struct NamedHand {
  std::string_view name;
  Hand hand;
};

/// Each has the wrist of its arm: with_wrist() of the hand.
/// From a firm grip to a tool that hangs on a thread. The numbers are chosen to span what is
/// published of fingers and wrists, and beyond it: no hand has no damping.
inline constexpr std::array<NamedHand, 8> kEightHands = {
    {{"usual", {.mass = 0.1, .damping = 5.0, .stiffness = 300.0}},
     {"light", {.mass = 0.02, .damping = 0.5, .stiffness = 50.0}},
     {"finger", {.mass = 0.01, .damping = 1.0, .stiffness = 150.0}},
     {"tether", {.mass = 0.0, .damping = 0.0, .stiffness = 30.0}},
     {"limp", {.mass = 0.1, .damping = 0.5, .stiffness = 30.0}},
     {"heavy", {.mass = 0.5, .damping = 2.0, .stiffness = 300.0}},
     {"strong", {.mass = 0.2, .damping = 10.0, .stiffness = 1000.0}},
     {"undamped", {.mass = 0.1, .damping = 0.0, .stiffness = 300.0}}}};

/// A plant for hands of a study: without the mass, damping and stiffness of its own hand.
inline Plant for_any_hand(Plant plant) {
  plant.hand.mass = plant.hand.damping = plant.hand.stiffness = std::nullopt;
  return plant;
}

}  // namespace feltwire
