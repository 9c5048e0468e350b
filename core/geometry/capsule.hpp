#pragma once

#include "core/geometry/primitive.hpp"

namespace feltwire {

/// A capsule around the z axis: a cylinder from -half_length to +half_length, with half spheres at
/// its ends.
struct Capsule {
  double radius = 0.0;       // [m], > 0
  double half_length = 0.0;  // [m], >= 0

  static constexpr const char* kName = "capsule";
  static constexpr bool kConvex = true;
  template <class Self, class Visit>
  static void lengths(Self& self, Visit visit) {
    visit(Length{.name = "radius"}, self.radius);
    visit(Length{.name = "length", .share = 0.5, .may_be_zero = true}, self.half_length);
  }

  SurfacePoint surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept;
  Grown<Capsule> grown(Side side, double ball) const noexcept;
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
