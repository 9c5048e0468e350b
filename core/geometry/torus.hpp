#pragma once

#include "core/geometry/primitive.hpp"

namespace feltwire {

/// A ring: all points within minor_radius of the circle of major_radius around the z axis.
///
/// Bodies collide with a ring of 24 capsules, whose middle line is off the circle by at most 0.43 %
/// of the major radius.
struct Torus {
  double major_radius = 0.0;  // [m] > 0
  double minor_radius = 0.0;  // [m] > 0, at most the major radius

  static constexpr const char* kName = "torus";
  static constexpr bool kConvex = false;
  template <class Self, class Visit>
  static void lengths(Self& self, Visit visit) {
    visit(Length{.name = "major_radius"}, self.major_radius);
    visit(Length{.name = "minor_radius", .most = self.major_radius}, self.minor_radius);
  }

  SurfacePoint surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept;
  Grown<Torus> grown(Side side, double ball) const noexcept;
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
