#pragma once
// How a simulated person means to turn the hand.

#include <array>
#include <cstdint>
#include <string_view>

#include "client/devices/hand_path.hpp"

namespace feltwire {

enum class WristPath : std::uint8_t { still, screwdriver, tilt, scrape, roll };
inline constexpr std::array<std::string_view, 5> kWristPathNames = {"still", "screwdriver", "tilt",
                                                                    "scrape", "roll"};
/// Throws std::invalid_argument naming the choices.
WristPath wrist_path(std::string_view name);

/// The movement of the wrist while the hand follows its path.
struct WristTask {
  WristPath path = WristPath::still;
  double angle = 0.3;  // [rad] amplitude, less than pi
};

/// The turn that the hand means, from the orientation in which it holds the tool. Axes, frequency
/// and lead-in are those of the hand's path: n its normal, u its `along`, w = n x u, and
/// a = 2 pi frequency t. Every turn grows from nothing within the lead-in.
///
/// still         none
/// screwdriver   angle sin a about n: turned in and out
/// tilt          a peg that is rocked into its hole: it leans by `angle`, and the lean goes round,
///               angle (cos a u + sin a w)
/// scrape        a blade that leans the way that slide() goes: angle cos a about w
/// roll          a tool that rolls along an edge with slide(): angle sin a about w, which is the
///               way of the hand over a radius of (amplitude / angle)
class IntendedTurn {
 public:
  /// Throws std::invalid_argument when the angle is not finite or reaches pi, or as IntendedMotion.
  IntendedTurn(const WristTask& wrist, const HandTask& hand);
  /// The intended rotation vector [rad], world frame, at time t >= 0 [s]. No state.
  Vec3 rotation(double t) const noexcept;

 private:
  WristTask wrist_;
  double frequency_, lead_in_, air_;  // [Hz], [s], [s]
  Vec3 normal_, along_, across_;
};

}  // namespace feltwire
