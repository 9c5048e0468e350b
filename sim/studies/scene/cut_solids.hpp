#pragma once
// Solids both as a closed surface and as convex parts, so that tools of points and of polygons can
// touch the same ones.

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// A solid in its own frame.
struct CutSolid {
  TriangleSoup surface;                  // closed, normals outwards
  std::vector<std::vector<Vec3>> parts;  // [m] the corners of each convex part
};

CutSolid box_solid(const Vec3& half);

/// A spur gear about z with involute flanks of a pressure angle of 20 degrees. A tooth points along
/// x. The parts are exactly the surface's solid: a hub and its teeth.
struct GearShape {
  int teeth = 16;
  double module = 2e-3;    // [m] pitch diameter over the number of teeth
  double width = 8e-3;     // [m] along z
  double backlash = 1e-4;  // [m] that a tooth is thinner than half a pitch
  double pitch_radius() const { return 0.5 * module * teeth; }
};
CutSolid gear_solid(const GearShape& gear);

/// A link of a chain: a rectangular ring of square bar in the plane of x and y. Its parts are four
/// bars.
struct LinkShape {
  double length = 40e-3, width = 24e-3, bar = 5e-3;  // [m] outside, along x and y
};
CutSolid link_solid(const LinkShape& link);

/// The bunny of scenes/bunny.obj, a hand high, about the middle of its bounds. `tolerance` [m]: how
/// far the parts may reach out of it. As in a scene, corners that stand out by less than a quarter
/// of that are left out. `triangles`: at least so many, by finer_surface(); the file has 3674.
CutSolid bunny_solid(double tolerance, std::size_t triangles = 0);

}  // namespace feltwire
