#pragma once
// The interface of a shape with a formula. Each such shape is a struct in its own file,
// with the members that the concept Primitive lists; shapes.hpp lists the shapes. Other code does
// not mention them by name, but for the plane, which has no triangles.

#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/proxy.hpp"
#include "core/geometry/triangle_soup.hpp"

namespace feltwire {

/// A signed distance and its gradient at a point.
struct FieldPoint {
  double distance = 0.0;         // [m] negative in the solid; NaN if the position is not finite
  Vec3 gradient = Vec3::Zero();  // of the distance, outwards; of length 1 where it is exact
};

/// The mass properties of a solid of density one.
struct MassProperties {
  double volume = 0.0;          // [m^3]
  Vec3 center = Vec3::Zero();   // [m] of mass
  Mat3 inertia = Mat3::Zero();  // [m^5] about the centre, along the frame's axes
};

/// A length of a shape in a scene file.
struct Length {
  const char* name;          // of the field; "size.x" is the x of a field "size" with x, y and z
  double share = 1.0;        // the shape's number over the file's number
  bool may_be_zero = false;  // false: it must be above zero
  double most = std::numeric_limits<double>::infinity();  // [m] largest allowed number in the file
};

/// A part of a shape's surface, seen from a point.
struct SurfacePart {
  double distance = 0.0;      // [m] a point nearer than this needs the part
  std::uint32_t feature = 0;  // index of the part, as in FeatureMemory
  bool shown =
      true;  // false: no patch of its own represents this part (the far parts of a capsule)
};

struct SurfaceParts {
  std::array<SurfacePart, 6> parts{};
  int count = 0;
  std::span<const SurfacePart> view() const {
    return {parts.data(), static_cast<std::size_t>(count)};
  }
};

/// A part of a surface as a plane, a ball or a cylinder, object frame. The members are those of a
/// SurfacePatch (core/local_model/local_model.hpp).
struct PatchGeometry {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  bool joined = false;
};

/// A solid that has grown by the radius of a ball: the ball touches the first one exactly where its
/// centre touches this one. It is `solid`, moved by `middle` [m]. If `round` [m] is above zero, its
/// surface is everywhere that far in front of `solid`, which makes the edges round.
template <class Solid>
struct Grown {
  Solid solid;
  Vec3 middle = Vec3::Zero();
  double round = 0.0;
};

/// A shape that moving bodies collide with: a geom of the physics engine, or a convex hull of
/// points.
struct PhysicsGeom {
  enum class Kind : std::uint8_t { plane, sphere, box, capsule, cylinder, hull };
  Kind kind = Kind::hull;
  /// [m] Of a sphere {radius, 0, 0}; of a capsule and a cylinder about z {radius, half length, 0};
  /// of a box its half extents.
  Vec3 size = Vec3::Zero();
  std::optional<Pose> pose{};  // in the shape's frame; empty: the shape's frame itself
  std::vector<Vec3> hull{};    // [m]
};

/// All members use the shape's own frame, whose origin is the middle of the shape's box. The
/// noexcept members never allocate.
template <class Shape>
concept Primitive = requires(const Shape& shape, Shape& given, Side side, const Vec3& p,
                             double number, FeatureMemory& memory, const FeatureMemory& remembered,
                             std::uint32_t feature, int whole, bool touching) {
  /// The name of the shape's field in a scene file.
  { Shape::kName } -> std::convertible_to<const char*>;
  /// Whether the solid has the line between any two of its points.
  { Shape::kConvex } -> std::convertible_to<bool>;
  /// Calls visit(Length, double&) for each of its numbers.
  Shape::lengths(given, [](const Length&, double&) {});
  Shape::lengths(shape, [](const Length&, double) {});

  /// The proxy of a point; see surface_point() of a Shape (core/contact/surface_point.hpp).
  { shape.surface_point(side, p, memory) }
  noexcept->std::same_as<SurfacePoint>;
  /// The solid that has grown by a ball of this radius [m] > 0, which touches it from that side.
  /// Precondition: from inside the radius is less than room().
  { shape.grown(side, number) }
  noexcept->std::same_as<Grown<Shape>>;
  /// [m] The radius of the largest ball within the solid.
  { shape.room() }
  noexcept->std::same_as<double>;
  /// The exact distance to the surface, negative in the solid. If several points of the surface are
  /// nearest, the gradient is that of one of them.
  { shape.signed_distance(p) }
  noexcept->std::same_as<FieldPoint>;
  /// [m] Half of the box about the solid; infinite if there is no such box.
  { shape.half_box() }
  noexcept->std::same_as<Vec3>;
  /// [m] The radius of the ball about the origin that holds the solid.
  { shape.reach() }
  noexcept->std::same_as<double>;
  /// Volume zero: the shape is unbounded.
  { shape.mass_properties() } -> std::same_as<MassProperties>;
  /// The surface as a closed mesh with outward normals. A round side has `segments` (at least 3)
  /// flat ones, with their corners on the surface. Empty: the shape is unbounded.
  { shape.triangles(whole) } -> std::same_as<TriangleSoup>;
  /// The geoms that bodies collide with. Empty: bodies pass through. If there are several geoms, or
  /// a hull, the shape's header states their error.
  { shape.geoms(side) } -> std::same_as<std::vector<PhysicsGeom>>;

  /// All parts of the surface. `feature` is the part that a tool at p touches, 0: none. See
  /// surface_parts() (core/local_model_extraction/patches.hpp).
  { shape.parts(side, p, feature) }
  noexcept->std::same_as<SurfaceParts>;
  /// The part with this index at its point nearest to p. `remembered` is a proxy that a touching
  /// tool has left behind.
  { shape.patch(side, p, whole, remembered, touching) }
  noexcept->std::same_as<PatchGeometry>;
};

}  // namespace feltwire
