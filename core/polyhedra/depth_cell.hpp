#pragma once
// Internal to the integrals of depth: those over one cell.

#include <span>

#include "core/polyhedra/depth_integrals.hpp"
#include "core/polyhedra/depth_planes.hpp"

namespace feltwire {

/// The part of space where one face is that to which depth is measured: d = inwards . x + constant.
struct Cell {
  Vec3 inwards, across, along;  // a right-handed frame: (across, along, inwards)
  double constant;              // [m]
  Vec3 origin;                  // [m] of the tool

  Cell(const Vec3& inwards_of, double constant_of, const Vec3& origin_of)
      : inwards(inwards_of), constant(constant_of), origin(origin_of) {
    across = inwards.unitOrthogonal();
    along = inwards.cross(across);
  }
};

/// Adds the integrals over what a cell and the tool's part have in common. `own`: the tag of faces
/// on the plane to which the depth is measured. Never allocates.
void add_cell(const ClippedPolyhedron& common, const Cell& cell, ClippedPolyhedron::Tag own,
              const DepthPlanes& planes, bool slides, DepthSums& sums) noexcept;

}  // namespace feltwire
