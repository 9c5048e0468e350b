#pragma once

#include <functional>

#include "sim/studies/bound/frontier.hpp"

namespace feltwire {

inline constexpr double kCalm = 10e-6;  // [m] RMS, below it a finger feels no oscillation

/// Rows of one case by several hands. A hand that swings is displayed nothing.
struct OverHands {
  std::size_t hands = 0, calm = 0;
  double median = 0.0, worst = 0.0;                          // displayed share
  double median_oscillation = 0.0, worst_oscillation = 0.0;  // [m]
  double energy_made = 0.0;                                  // [J] the most
  double made_at_motor = 0.0;                                // [J] the most
};
using Picks = std::function<bool(const FrontierCase&)>;

OverHands over_hands(const std::vector<FrontierRow>& rows, const Picks& picks);

}  // namespace feltwire
