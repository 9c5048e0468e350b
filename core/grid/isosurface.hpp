#pragma once
// The surface of a distance field as triangles, for pictures.

#include "core/geometry/triangle_soup.hpp"
#include "core/grid/distance_grid.hpp"

namespace feltwire {

/// The surface where the distance is zero, in the grid's frame, by surface nets (Gibson 1998): one
/// vertex in each cell that the surface passes through. The cells are cubes; `steps` (2 to 256) of
/// them lie along the grid's longest side. Parts that are thinner than a cell may be missing.
/// Allocates. Throws std::invalid_argument for other steps.
TriangleSoup isosurface(const DistanceGrid<float>& grid, int steps);

}  // namespace feltwire
