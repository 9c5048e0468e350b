#pragma once
// The solids that a tool of polygons touches: a solid as convex parts.

#include <cstdint>
#include <vector>

#include "core/geometry/shapes.hpp"
#include "core/polyhedra/polyhedron.hpp"

namespace feltwire {

/// A convex part of a solid, in the object's frame.
struct SolidPart {
  Polyhedron shape;                 // of a plane only the one face, without vertices
  std::vector<std::uint8_t> inner;  // for each face: it lies within the solid, on another part
  /// Surface of neighbours behind which this part lies as a whole. With them the depth in two
  /// pieces of one convex solid is that in the solid.
  std::vector<HalfSpaceBelow> beyond;
};

/// A solid, in the object's frame.
struct SolidParts {
  std::vector<SolidPart> parts;
  /// The solid is all that lies outside of the only part: a hollow that is felt from inside.
  bool hollow = false;
  Vec3 centre = Vec3::Zero();  // [m] of a ball that holds all parts; infinite for a plane
  double radius = 0.0;         // [m]
};

/// A round side becomes so many flat ones.
inline constexpr int kRoundSegments = 64;

/// The parts of a union of convex solids, each given by its corners [m]. Throws as polyhedron()
/// does.
SolidParts solid_parts(const std::vector<std::vector<Vec3>>& corners);

/// The parts of a shape without a decomposition: a plane, a box, a sphere, a capsule, a cylinder, a
/// cone, or a mesh that is convex. Round ones become polyhedra with kRoundSegments flat sides whose
/// corners lie on the surface, or fewer where they would have too many corners. Throws
/// std::invalid_argument with a remedy for all others: a torus, a grid, a mesh that is not closed
/// or not convex.
SolidParts solid_parts(const Shape& shape, Side felt_from);

}  // namespace feltwire
