#pragma once

#include "core/geometry/primitive.hpp"

namespace feltwire {

/// The half space z <= 0 is solid.
struct Plane {
  static constexpr const char* kName = "plane";
  static constexpr bool kConvex = true;
  template <class Self, class Visit>
  static void lengths(Self&, Visit) {}

  SurfacePoint surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept;
  Grown<Plane> grown(Side side, double ball) const noexcept;
  double room() const noexcept;
  FieldPoint signed_distance(const Vec3& p) const noexcept;
  Vec3 half_box() const noexcept;
  double reach() const noexcept;
  MassProperties mass_properties() const;
  TriangleSoup triangles(int segments) const;
  std::vector<PhysicsGeom> geoms(Side side) const;
  SurfaceParts parts(Side side, const Vec3& p, std::uint32_t entered) const noexcept;
  PatchGeometry patch(Side side, const Vec3& p, int face, const FeatureMemory& memory,
                      bool touching) const noexcept;
};

}  // namespace feltwire
