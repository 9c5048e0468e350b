#pragma once
// The part of a closed mesh below planes.

#include <cstdint>
#include <utility>
#include <vector>

#include "core/convex/convex_hull.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// The part below planes of the solid that a closed mesh bounds: its surface in polygons, and the
/// corners of the cell of planes that lie in the solid. The hull of these points is the hull of
/// this part. Coordinates are relative to the mesh's origin.
class ClippedSolid {
 public:
  /// The whole solid. The surface is closed with its normals outwards and outlives this.
  explicit ClippedSolid(const MeshSurface& solid);

  /// The points whose hull is that of the parts below and above a plane.
  std::pair<std::vector<Vec3>, std::vector<Vec3>> points_beside(const HalfSpaceBelow& cut) const;
  /// The part below the plane.
  ClippedSolid below(const HalfSpaceBelow& cut) const;
  /// The points whose hull is that of the whole.
  std::vector<Vec3> points() const;

  /// Candidate planes: evenly spaced ones along the axes, and those of the faces that meet in the
  /// sharpest hollow edges.
  std::vector<HalfSpaceBelow> cuts() const;

 private:
  using Polygon = std::vector<std::uint32_t>;
  ClippedSolid(const MeshSurface& solid, double rounding) : solid_(&solid), rounding_(rounding) {}
  bool crosses(double a, double b) const;
  std::vector<double> heights_over(const HalfSpaceBelow& cut) const;
  /// Corners of the cell that lie on the plane, inside the solid.
  std::vector<Vec3> corners_on(const HalfSpaceBelow& cut) const;

  const MeshSurface* solid_;
  double rounding_;  // [m] points within this distance of a plane lie on it
  std::vector<Vec3> vertices_;
  std::vector<Polygon> polygons_;
  std::vector<HalfSpaceBelow> cell_;
  std::vector<Vec3> corners_;  // of the cell, in the solid
};

}  // namespace feltwire
