#pragma once
// Solids in their own frame, and where a point in one of them is pushed out.

#include <cstdint>
#include <memory>
#include <variant>

#include "core/base/types.hpp"

namespace feltwire {

/// The half space z <= 0 is solid.
struct Plane {};
/// Centred on the origin.
struct Sphere {
  double radius = 0.0;  // [m], > 0
};
/// Centred, along the axes.
struct Box {
  Vec3 half_extents = Vec3::Zero();  // [m], each > 0
};
/// Around the z axis, from -half_length to +half_length, with half spheres beyond.
struct Capsule {
  double radius = 0.0;       // [m], > 0
  double half_length = 0.0;  // [m], >= 0
};
/// Around the z axis, from -half_length to +half_length, flat ends.
struct Cylinder {
  double radius = 0.0;       // [m], > 0
  double half_length = 0.0;  // [m], > 0
};
class MeshSurface;
/// Triangles, with what a hand needs to find its way on them; shared, immutable.
struct Mesh {
  std::shared_ptr<const MeshSurface> surface;  // never null in a scene
};
template <class Real>
class DistanceGrid;
/// Whatever was sampled (core/grid/distance_grid.hpp).
struct Grid {
  std::shared_ptr<const DistanceGrid<float>> field;  // never null
};
using Shape = std::variant<Plane, Sphere, Box, Capsule, Cylinder, Mesh, Grid>;

/// Which side of the surface is free to move in.
enum class Side : std::uint8_t { outside, inside };

/// Where the (frictionless) proxy stands on the surface, object frame.
struct SurfacePoint {
  Vec3 point = Vec3::Zero();    // [m] on the surface
  Vec3 normal = Vec3::UnitZ();  // unit, towards the free side
  double depth = 0.0;           // [m] |position - point|, 0 when free
};

/// Faces by index. Of a box: +x, -x, +y, -y, +z, -z; of a cylinder as named; all other shapes have
/// one.
inline constexpr int kBoxFaces = 6;
inline constexpr int kCylinderSide = 0, kCylinderTop = 1, kCylinderBottom = 2;

/// What the proxy must remember of one shape between samples, so that it does not jump through a
/// thin solid.
struct FeatureMemory {
  std::uint32_t feature = 0;    // 0: not in contact; else 1 + index of the face the proxy stands on
  Vec3 normal = Vec3::UnitZ();  // last one, of the surface at the proxy: what is used where the
                                // geometry leaves it undefined (a centre, an axis)
  // Of a mesh and a solid felt from outside: where the proxy was, free or not (on what is round,
  // where the tool was), so that the way to where the tool is now is followed, passing nothing by.
  Vec3 proxy = Vec3::Zero();   // [m, object frame, from origin_of() the shape]
  std::uint32_t triangle = 0;  // of a mesh: that it stands on
  std::int8_t side = 0;        // 0: the proxy is free. Of a mesh's triangle: 1 where its normal
                               // points, -1 behind. Of a solid: 1
  bool tracked = false;        // proxy is known
};
/// The proxy of a point on one solid, as surface_point() of a Shape says (surface_point.hpp).
SurfacePoint surface_point(const Plane& plane, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept;
SurfacePoint surface_point(const Sphere& sphere, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept;
SurfacePoint surface_point(const Box& box, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept;
SurfacePoint surface_point(const Capsule& capsule, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept;
SurfacePoint surface_point(const Cylinder& cylinder, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept;

}  // namespace feltwire
