#pragma once
// The surfaces that a robot touched before.

#include <array>
#include <cstdint>
#include <optional>

#include "core/teleoperation/remote_contact.hpp"

namespace feltwire {

/// A surface and what its estimate needs when the robot touches it again.
struct KnownSurface {
  RemoteContact contact;
  bool settled = false;         // its normal is known from a long touch
  bool learnt = false;          // its stiffness is known from a touch
  double impulse = 0.0;         // [N s] of its young touches
  Vec3 touched = Vec3::Zero();  // [m] on it, where it was touched last
  double absent = 0.0;          // [s] in which the tool found nothing there
  bool told = false;            // it is one of the OtherSurfaces
};

/// Remembers up to kRemembered surfaces near the tool; a new one replaces the farthest. A surface
/// is forgotten when
///   - the tool is inside it for kAbsent without half of the force that it would have: it has moved
///     or gone, or it ends before that place;
///   - the tool is farther than kNear from the place where it was touched.
/// Which surfaces are told: the nearest ones. A surface that comes back to them gets another
/// number: a hand that did not know of it meets it where the hand is (SurfaceOffset).
///
/// No function allocates, throws or reads a clock.
class SurfaceMemory {
 public:
  static constexpr std::size_t kRemembered = 8;
  static constexpr double kNear = 50e-3;    // [m]
  static constexpr double kAbsent = 10e-3;  // [s]
  static constexpr double kClear = 0.4;     // [N] force that should be felt for certain

  /// Remembers a surface. Its number is not among the remembered ones.
  void keep(const KnownSurface& surface, const Vec3& tip) noexcept;

  /// Takes out the surface that can have this force: the nearest one whose plane is within `reach`
  /// [m] of the tip and whose normal is within 45 degrees of the force's `direction`.
  std::optional<KnownSurface> take(const Vec3& tip, const Vec3& direction, double reach) noexcept;

  /// Forgets what the tool disproves at `tip`, where `force` [N] acts on it, and tells the nearest
  /// ones. `counted`: the number given last, raised for each new one.
  void step(const Vec3& tip, const Vec3& force, double elapsed, std::uint32_t& counted) noexcept;

  const OtherSurfaces& told() const noexcept { return told_; }

 private:
  void forget(std::size_t i) noexcept { known_[i] = known_[--count_]; }

  std::array<KnownSurface, kRemembered> known_{};
  std::size_t count_ = 0;
  OtherSurfaces told_;
};

}  // namespace feltwire
