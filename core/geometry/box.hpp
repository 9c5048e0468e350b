#pragma once

#include "core/geometry/primitive.hpp"

namespace feltwire {

/// Its faces by index: +x, -x, +y, -y, +z, -z.
inline constexpr int kBoxFaces = 6;

/// A box centred on the origin, with edges along the axes.
struct Box {
  Vec3 half_extents = Vec3::Zero();  // [m], each > 0

  static constexpr const char* kName = "box";
  static constexpr bool kConvex = true;
  template <class Self, class Visit>
  static void lengths(Self& self, Visit visit) {
    visit(Length{.name = "size.x", .share = 0.5}, self.half_extents.x());
    visit(Length{.name = "size.y", .share = 0.5}, self.half_extents.y());
    visit(Length{.name = "size.z", .share = 0.5}, self.half_extents.z());
  }

  SurfacePoint surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept;
  Grown<Box> grown(Side side, double ball) const noexcept;
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
