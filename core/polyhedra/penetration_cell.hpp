#pragma once
// Internal to the integrals of depth: those over the cells.

#include <span>

#include "core/polyhedra/closest_face_cells.hpp"
#include "core/polyhedra/depth_integrals.hpp"
#include "core/polyhedra/depth_planes.hpp"

namespace feltwire {

/// The part of space where one face is that to which depth is measured: d = inwards . x + constant.
struct PenetrationCell {
  Vec3 inwards, across, along;  // a right-handed frame: (across, along, inwards)
  double constant;              // [m]
  Vec3 origin;                  // [m] of the tool
  ClosestFaceCells::Tag own;    // of faces on the plane to which the depth is measured

  PenetrationCell() = default;
  PenetrationCell(const Vec3& inwards_of, double constant_of, const Vec3& origin_of,
                  ClosestFaceCells::Tag own_of)
      : inwards(inwards_of), constant(constant_of), origin(origin_of), own(own_of) {
    across = inwards.unitOrthogonal();
    along = inwards.cross(across);
  }
};

/// Adds the integrals over cells, of which cell k has the number k. Never allocates.
void add_cells(const ClosestFaceCells& cells, std::span<const PenetrationCell> of,
               const DepthPlanes& planes, bool slides, DepthSums& sums) noexcept;

}  // namespace feltwire
