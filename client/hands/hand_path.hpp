#pragma once
// The intended path of a simulated hand.

#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/types.hpp"

namespace feltwire {

enum class HandPath { press, slide, orbit, figure_eight, taps, strike };
/// The paths that a command line offers: all except strike, because few workspaces have room for
/// its run-up.
inline constexpr std::array<std::string_view, 5> kHandPathNames = {"press", "slide", "orbit",
                                                                   "figure-eight", "taps"};
/// Throws std::invalid_argument that lists the choices.
HandPath hand_path(std::string_view name);

/// A task of a hand at a surface. It begins `clearance` outside and comes in smoothly within
/// `lead_in`; only strike begins farther out.
struct HandTask {
  HandPath path = HandPath::press;
  Vec3 center = Vec3::Zero();   // [m] a point of the surface; for orbit the centre of the circle
  Vec3 normal = Vec3::UnitZ();  // outward normal of the surface there
  Vec3 along = Vec3::UnitX();   // first direction of movement, made orthogonal to the normal
  double radius = 0.03;         // [m] amplitude of slide and figure-eight, radius of orbit
  double frequency = 0.5;       // [Hz]
  double depth = 0.01;          // [m] intended depth of the hand below the surface
  double clearance = 0.01;      // [m]
  double lead_in = 0.5;         // [s]
  double air = 0.0;             // [s] time that it moves outside the surface before it comes in
  double speed = 1.0;           // [m/s] of strike
  double tremor = 0.0;          // [m] RMS an axis, 8 to 12 Hz
  std::uint64_t seed = 1;       // seed of the tremor
};

/// Turns the task to a surface with another outward normal, and `along` into that surface.
void set_normal(HandTask& task, const Vec3& normal);

/// Makes it an orbit round a ball of `radius` [m] about the centre, `depth` below its surface, in
/// the x-z plane, four seconds a turn.
void go_round(HandTask& task, double radius);

/// Returns 3 s^2 - 2 s^3, s limited to 0..1: the smooth start of a task.
double smoothstep(double s) noexcept;

/// press         to `depth`, and stay
/// slide         press, and move along by radius * sin
/// orbit         a circle of `radius` in the plane of along and normal x along, pressed `depth`
/// below it orbit about a ball: give the circle radius (ball radius - depth) and depth 0
/// figure_eight  press, and a 1:2 Lissajous figure in the surface
/// taps          in and out along the normal, from +clearance to -depth
/// strike        up to `speed` within `lead_in` (over speed * lead_in / 2), at that speed through
/// `clearance` and on to `depth`, and stay
class IntendedMotion {
 public:
  /// Throws std::invalid_argument if a number is not finite, or if normal and along are parallel or
  /// zero.
  explicit IntendedMotion(const HandTask& task);
  /// Returns the intended position [m] at time t >= 0 [s]. There is no state: the same t gives the
  /// same point.
  Vec3 position(double t) const noexcept;

 private:
  Vec3 on_path(double t) const noexcept;
  Vec3 with_tremor(Vec3 p, double t) const noexcept;
  struct Tone {
    double frequency, phase;  // [Hz], [rad]
  };
  static constexpr int kTones = 3;  // number of sine waves of a tremor axis, between 8 and 12 Hz

  HandTask task_;
  Vec3 across_;
  std::array<std::array<Tone, kTones>, 3> tremor_;
};

}  // namespace feltwire
