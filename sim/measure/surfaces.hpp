#pragma once
// Surfaces of the lab that a scene file cannot describe, and the distance of a point from them.

#include "sim/measure/experiment.hpp"

namespace feltwire {

/// The relation of a point to a surface.
struct SurfaceDistance {
  double distance = 0.0;        // [m] negative inside the solid
  Vec3 normal = Vec3::UnitZ();  // unit, outwards
};

/// Solid below z = 0.
SurfaceDistance plane_distance(const Vec3& point);
/// A ball about the origin. radius [m].
SurfaceDistance sphere_distance(const Vec3& point, double radius);
/// The inside of a room's corner: free where x, y and z are all positive. Exact: in the solid the
/// distance is to the nearest point of the free octant (Zilles and Salisbury's proxy), so a hand
/// in the corner is pushed by two or three walls at once.
SurfaceDistance corner_distance(const Vec3& point);
/// The walls that push a point there.
ContactNormals corner_walls(const Vec3& point);
/// A sharp convex edge along z: solid where x and y are both negative. The distance is exact; the
/// normal in the solid is that of the nearest face.
SurfaceDistance edge_distance(const Vec3& point);

/// A torus about the z axis with bumps: the zero set of
///   f = sqrt((rho - R)^2 + z^2) - r - a cos(m phi) cos(n theta),   rho = sqrt(x^2 + y^2),
/// phi the angle about the axis, theta the one about the tube (0 outside).
struct BumpyTorus {
  double ring = 0.06;       // R [m] of the tube's centre line
  double tube = 0.03;       // r [m]
  double amplitude = 1e-3;  // a [m]
  int round_axis = 24;      // m bumps; on the outside 23.6 mm from one to the next
  int round_tube = 8;       // n bumps, also 23.6 mm apart
};
/// f of the torus, f = 0 on it [m], and its gradient.
struct ImplicitValue {
  double value = 0.0;
  Vec3 gradient = Vec3::Zero();
};
/// Precondition: the point is neither on the axis nor on the tube's centre line, where f has no
/// gradient.
ImplicitValue bumpy_torus(const BumpyTorus& torus, const Vec3& point);
/// First-order distance f / |grad f| along the gradient (Taubin 1994); its error is of second order
/// in the distance. Precondition as bumpy_torus().
SurfaceDistance torus_distance(const BumpyTorus& torus, const Vec3& point);

/// stiffness * depth along the normal, in the solid.
Command penalty(const SurfaceDistance& surface, double stiffness);

/// An object as the environment of a tool, in a fresh state.
Environment environment(const Object& object);

}  // namespace feltwire
