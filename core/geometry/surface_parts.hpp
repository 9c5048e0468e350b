#pragma once
// The common code of the primitives that divide their surface into parts.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/numeric.hpp"
#include "core/geometry/primitive.hpp"

namespace feltwire {

inline constexpr std::uint32_t kOnlyFeature = 1;

// A distance that underflows here counts as zero, which is on the safe side; a scene has no lengths
// that would overflow.
inline double root(double a, double b) { return std::sqrt(a * a + b * b); }

inline std::uint32_t feature_of(int face) { return static_cast<std::uint32_t>(1 + face); }
inline int face_of(std::uint32_t feature) { return static_cast<int>(feature) - 1; }
inline double outward_sign(Side side) { return side == Side::outside ? 1.0 : -1.0; }

inline void add(SurfaceParts& all, double distance, std::uint32_t feature, bool shown = true) {
  all.parts[static_cast<std::size_t>(all.count++)] = {distance, feature, shown};
}

/// Adds a face of a convex solid that several faces bound. The face begins to count where the solid
/// does, and where the tool could be beyond this face and inside the others. The face that the tool
/// touches counts everywhere.
inline void add_convex(SurfaceParts& all, double beyond, double solid, int face,
                       std::uint32_t entered) {
  const std::uint32_t feature = feature_of(face);
  add(all, feature == entered ? 0.0 : std::max(beyond, solid), feature);
}

inline double height(Side side, double distance, double radius) {
  return side == Side::outside ? distance - radius : radius - distance;
}

/// A proxy that was left behind holds the tool everywhere.
inline double unless_entered(double distance, Side side, std::uint32_t entered) {
  return side == Side::outside && entered == kOnlyFeature ? 0.0 : distance;
}

inline Vec3 or_else(const Vec3& direction, const Vec3& other) {
  return direction.isZero(0.0) ? other : direction;
}

inline PatchGeometry round_patch(Side side, const Vec3& core, const Vec3& outward, double radius) {
  const double sign = outward_sign(side);
  return {.point = core + radius * outward, .normal = sign * outward, .curvature = sign / radius};
}

/// Returns the normal of a proxy that was left behind on another side than p. Null: it is above p,
/// or p does not touch this face.
inline const Vec3* left_behind(Side side, int face, const Vec3& outward,
                               const FeatureMemory& feature, bool touching) {
  constexpr double kRounding = 1e-9;
  if (side != Side::outside || !touching || face_of(feature.feature) != face || feature.side == 0 ||
      length(Vec3(feature.normal - outward)) < kRounding)
    return nullptr;
  return &feature.normal;
}

/// Returns the direction from the z axis to p; on the axis the horizontal part of the remembered
/// normal.
inline Vec3 across_axis(const Vec3& p, const FeatureMemory& memory) {
  const Vec3 remembered(memory.normal.x(), memory.normal.y(), 0.0);
  return or_else(direction(Vec3(p.x(), p.y(), 0.0)), or_else(direction(remembered), Vec3::UnitX()));
}

}  // namespace feltwire
