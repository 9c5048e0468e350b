#pragma once
// The bars of a real device, on hands and plants that no threshold was chosen with.

#include <cstdint>
#include <string>
#include <vector>

#include "sim/studies/bound/frontier.hpp"

namespace feltwire {

/// Cases of one bar: the same law, device, wall, lag and transmission in every hand.
struct JudgedBar {
  std::string name;
  FrontierCase shared;        // without hand and plant
  double lag = 0.0;           // [s] of the amplifier, and as the law and the account are told
  double transmission = 0.0;  // [N/m] 0: rigid
};

/// Presses of a device like a PHANToM Premium 1.5 whose lag is told: `shaped` on 5 and 40 kN/m,
/// cold and warm, rigid and behind transmissions, with what would show more of a cold wall; and
/// `contact_frame`.
std::vector<JudgedBar> judged_bars();

/// A bar in the eight hands and in `hands` drawn ones (5 g to 0.5 kg, 0.3 to 10 N s/m, 30 to 1000
/// N/m). The eight have a first-order lag. Each drawn hand has a plant of its own: a first-order
/// lag, a delay or both within the told time, the damping and the handle mass of the transmission,
/// stiction, noise of the encoder and steps of the force. The same `seed` draws the same.
std::vector<FrontierCase> judged_cases(const JudgedBar& bar, std::uint64_t seed, int hands);

/// The share of a press of 3 N that a cold account can pay for, at most, if it is charged for
/// nothing but the movement: the energy of the way in and of the press, against what the held force
/// needs. 1 if it pays for the wall.
double paid_share(const JudgedBar& bar);

/// For people: a line for each bar.
std::string judged_table(std::uint64_t seed, int hands);

}  // namespace feltwire
