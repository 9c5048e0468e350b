#pragma once
// The intended rotation of a simulated hand.

#include <array>
#include <cstdint>
#include <string_view>

#include "client/hands/hand_path.hpp"

namespace feltwire {

enum class WristPath : std::uint8_t { still, screwdriver, tilt, scrape, roll };
inline constexpr std::array<std::string_view, 5> kWristPathNames = {"still", "screwdriver", "tilt",
                                                                    "scrape", "roll"};
/// Throws std::invalid_argument that lists the choices.
WristPath wrist_path(std::string_view name);

/// The movement of the wrist while the hand follows its path.
struct WristTask {
  WristPath path = WristPath::still;
  double angle = 0.3;  // [rad] amplitude, less than pi
};

/// The intended rotation, relative to the orientation in which the hand holds the tool. Axes,
/// frequency and lead-in are those of the hand's path: n is its normal, u its `along`, w = n x u,
/// and a = 2 pi frequency t. Every rotation grows from zero within the lead-in.
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
  /// Throws std::invalid_argument if the angle is not finite or reaches pi, and the errors of
  /// IntendedMotion.
  IntendedTurn(const WristTask& wrist, const HandTask& hand);
  /// Returns the intended rotation vector [rad], world frame, at time t >= 0 [s]. There is no
  /// state.
  Vec3 rotation(double t) const noexcept;

 private:
  WristTask wrist_;
  double frequency_, lead_in_, air_;  // [Hz], [s], [s]
  Vec3 normal_, along_, across_;
};

}  // namespace feltwire
