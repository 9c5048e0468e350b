#pragma once
// The integrals of depth over what a convex tool part and a solid's part have in common.
//
// The law. Let d(x) be the depth of a point x below the surface of a solid: its distance to the
// nearest face. A rigid tool T stores in the solid
//   E(T) = C sqrt(V),   V = integral of d^3 over T inside the solid,   C = k / sqrt(A_c),
// k [N/m] the material's stiffness and A_c [m^2] the contact area. Why this one:
// - A flat face of area A pressed in by h has V = A h^4 / 4, so E = k sqrt(A / A_c) h^2 / 2: a
//   spring, whose stiffness is the material's where A = A_c.
// - All else follows without another number, in the exponents of an elastic half space: a sphere
//   F ~ h^1.5 (Hertz 1882), a cone or a corner F ~ h^2 (Sneddon 1965), an edge F ~ h^1.5, a punch
//   of area A F ~ sqrt(A) h (Boussinesq 1885). With C = 2 E* / sqrt(pi), that of the round punch,
//   the sphere's force is 1.19 and the cone's 1.22 times theirs, and a round punch that rocks has
//   1.12 times its stiffness. So an edge and a corner have a law, though their area is zero. In
//   Winkler's bed of springs (the points of core/point_shell/shell_contact) a corner is softer, F ~
//   h^3.
// - d is continuous and zero on the surface. So the gradient of V is continuous in the pose: no
//   force jumps where the tool comes over a sharp edge, and no edge is rounded for that.
// - V grows with every d. So no place of the tool is ever pulled into a solid.
//
// Its force. In the solid's frame d is fixed and the tool moves. For a motion of the tool that
// gives its points the velocity v, dV/dt is the integral of d^3 v . n over the tool's surface
// inside the solid (Reynolds 1903), exactly. Inside a cell where one face i is the nearest, d =
// o_i - n_i . x. With Gauss, as v has no divergence,
//   dV/dt = - integral of 3 d^2 n_i . v over the cells - integral of d^3 v . m over the inner
//   faces,
// m the normal of faces at which the part ends inside the solid. On all other faces d^3 vanishes or
// cancels with the cell beside.
//
// Its stiffness. The second derivative of V is H - R, H = 6 integral of d w w^T over the cells, w =
// (n, r x n), less terms of rotation (force times arm) and of inner faces. R is that of the ridges:
// across one between cells i and j the gradient of d jumps by n_i - n_j = -|n_i - n_j| q, q the
// ridge's normal, so that R = 3 |n_i - n_j| integral of d^2 z z^T over its area, z = (q, r x q). On
// the face of a cell beside, the ridge has |n_i - n_j| / 2 of its area: R = 6 integral of d^2 z z^T
// there. With s = 3 integral of d^2 w the second derivative of E is
//   C / (2 sqrt V) (H - R - s s^T / (2 V)).
// By Cauchy and Schwarz s s^T <= 3/2 V H, so without R it is at least a quarter of its first term:
// positive semidefinite, and exactly k sqrt(A / A_c) for a flat face. With R it may have negative
// eigenvalues, where the tool has no place of rest.
//
// Passivity. E is a potential of the pose. So step_coupled_tool(), which only goes down, stores no
// more than the hand's work against the coupling. This holds for any d that is fixed during a step.
//
// Thin walls. A wall of 0.2 mm would hold a tool only until its middle. So a pair of parts keeps
// the direction `away`, from the solid to the tool, from when they were apart. The solid is
// thickened against this direction: its surface faces that look away from the tool are left out,
// and planes through the outline take their place. This is S + {-s away, s >= 0}. A plane that
// separated the two still does so, and no depth takes the tool through.

#include "core/polyhedra/clipped_polyhedron.hpp"
#include "core/polyhedra/solid_parts.hpp"
#include "core/tool_coupling/slip_sums.hpp"

namespace feltwire {

/// Sums over pairs of parts of one object, in its frame; arms from the tool's origin.
struct DepthSums {
  double cubes = 0.0;             // [m^6] V
  Vec6 slope = Vec6::Zero();      // [m^5], [m^6/rad] gradient of V for motions of the tool
  Vec6 pushed = Vec6::Zero();     // its part from the cells, -s
  Mat6 curvature = Mat6::Zero();  // [m^4] ... H
  Mat6 ridges = Mat6::Zero();     // [m^4] ... R
  std::array<SlipSums, 6> sides;  // of the contact, by the axis that the normal is nearest to;
                                  // their weight is the integral of d^2 [m^5]
  std::size_t cells = 0;          // with contact

  DepthSums& operator+=(const DepthSums& more) noexcept {
    cubes += more.cubes;
    slope += more.slope;
    pushed += more.pushed;
    curvature += more.curvature;
    ridges += more.ridges;
    for (std::size_t i = 0; i < sides.size(); ++i) sides[i] += more.sides[i];
    cells += more.cells;
    return *this;
  }
};

/// A convex part of the tool in an object's frame.
struct PlacedPart {
  const Polyhedron& shape;
  const Mat3& rotation;
  const Vec3& origin;  // [m] of the tool's frame
};

/// Adds the integrals of one pair. `away`: unit, object frame; null: the solid is not thickened.
/// More than kMostDepthPlanes planes of one part are not looked at. Never allocates; some 600 KiB
/// of stack.
void add_depth(const PlacedPart& tool, const SolidPart& solid, bool hollow, const Vec3* away,
               bool slides, DepthSums& sums) noexcept;

inline constexpr std::size_t kMostDepthPlanes = 2048;

}  // namespace feltwire
