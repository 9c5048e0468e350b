// Describes a mesh as patches: either as one curved patch, or as up to three planes with the edges
// between them. Chooses the description that is valid to the larger distance. The curvature comes
// from the change of the normals around the point.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/numeric.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"
#include "core/local_model_extraction/mesh_fit.hpp"
#include "core/mesh/height_map.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

// Search radius, as a multiple of the first triangle's side length.
constexpr double kFittedSides = 3.0;
// Facets that turn by at most this angle [rad] count as parts of a smooth surface. The middle of an
// equilateral facet is kSagitta * angle * side away from the ball through its corners. The middle
// of any other facet is farther away.
constexpr double kMostTurned = 0.15, kSagitta = 0.25;
constexpr std::uint32_t kNone = TriangleMesh::kNone;

/// The point of the surface that is nearest to a tool.
struct NearestSurface {
  Vec3 point = Vec3::Zero();
  std::uint32_t triangle = kNone;
  double side = 0.0;      // side of the surface that faces the tool: 1 or -1; 0 if there is none
  double distance = 0.0;  // [m] distance from the tool to the surface; 0 in contact
  double height = 0.0;    // [m] distance from the point to the tool
};

NearestSurface nearest_surface(const MeshSurface& surface, Side felt_from, const Vec3& goal,
                               const FeatureMemory& memory, double ball) {
  if (memory.side != 0) {
    // The proxy of a ball is its centre. The contact point is the nearest point of the triangle.
    const Vec3 closest =
        ball > 0.0
            ? nearest_on_triangle(surface.mesh().corners(memory.triangle), memory.proxy).point
            : memory.proxy;
    return {closest, memory.triangle, static_cast<double>(memory.side), 0.0,
            (goal - closest).norm()};
  }
  const auto found = surface.nearest(goal, kMostFitted);
  NearestSurface nearest{found.point, found.triangle, 0.0, found.distance, found.distance};
  if (!(found.distance <= kMostFitted)) return nearest;
  const double off = surface.side_of(goal, found);
  const double side = felt_from == Side::outside ? 1.0 : -1.0;
  if (surface.options().double_sided) {
    nearest.side = off < 0.0 ? -1.0 : 1.0;
  } else if (side * off >= 0.0) {
    nearest.side = side;
  } else if (const std::uint32_t reverse = surface.mesh().reverse_of(found.triangle);
             reverse != kNone) {
    nearest.triangle = reverse;
    nearest.side = side;
  }  // Otherwise the tool is behind the surface, without contact.
  return nearest;
}

MeshFit plane(const MeshSurface& surface, std::uint32_t t, double side, const Vec3& point) {
  MeshFit fit;
  fit.point = point;
  fit.normal = side * triangle_normal(surface.mesh().corners(t));
  fit.triangle = t;
  return fit;
}

/// Returns the side length [m] of an equilateral triangle with about the same area.
double side_of(const std::array<Vec3, 3>& c) {
  return std::sqrt((c[1] - c[0]).cross(c[2] - c[0]).norm());
}

/// Fits a patch with the curvature of one triangle, from the normals at its corners (Rusinkiewicz
/// 2004).
MeshFit curved(const MeshSurface& surface, const NearestSurface& nearest) {
  MeshFit fit = plane(surface, nearest.triangle, nearest.side, nearest.point);
  const std::array<Vec3, 3> c = surface.mesh().corners(nearest.triangle);
  const Triangle& corner = surface.mesh().triangles()[nearest.triangle];
  std::array<Vec3, 3> normals;
  for (std::size_t k = 0; k < 3; ++k) normals[k] = nearest.side * surface.normal_at(corner[k]);
  const Vec3 weights = nearest_on_triangle(c, nearest.point).weights;
  const Vec3 normal =
      direction(Vec3(weights[0] * normals[0] + weights[1] * normals[1] + weights[2] * normals[2]));
  if (normal.isZero(0.0)) return fit;
  const Vec3 a = c[1] - c[0], b = c[2] - c[0];
  const Vec3 u = direction(Vec3(a - along(a, normal))), v = normal.cross(u);
  Eigen::Matrix2d edges, turns;
  edges << a.dot(u), b.dot(u), a.dot(v), b.dot(v);
  turns << (normals[1] - normals[0]).dot(u), (normals[2] - normals[0]).dot(u),
      (normals[1] - normals[0]).dot(v), (normals[2] - normals[0]).dot(v);
  const Eigen::Matrix2d turn = turns * edges.inverse();
  if (!turn.allFinite()) return fit;
  const LocalCurvature bent =
      local_curvature(u, v, turn(0, 0), 0.5 * (turn(0, 1) + turn(1, 0)), turn(1, 1));
  fit.normal = normal;
  fit.curvature = bent.curvature;
  fit.axis = bent.axis;
  const double side = side_of(c), turned = std::abs(bent.curvature) * side;
  if (turned < kMostTurned) fit.slack = kSagitta * turned * side;
  return fit;
}

/// Returns the number of the fit's flat face, or one common number for all curved fits. Different
/// faces have different numbers.
std::uint32_t feature_of(const MeshSurface& surface, const MeshFit& fit) {
  constexpr std::uint32_t kRound = 1, kFirstFace = 2;
  return fit.curvature != 0.0 ? kRound : kFirstFace + surface.face(fit.triangle);
}

/// Returns true if a patch is valid at the distance `radius`, beyond the triangles that were
/// examined. At eight points of this ring, the patch must lie on the surface, and the space above
/// must be free.
bool holds_at(const MeshSurface& surface, const MeshFit& fit, double side, double radius) {
  constexpr int kPlaces = 8;
  constexpr double kOpen = 0.75;  // radius of the free ball above the patch, as a share of `radius`
  SurfacePatch patch;
  patch.point = fit.point;
  patch.normal = fit.normal;
  patch.axis = fit.axis;
  patch.curvature = fit.curvature;
  const auto free = [&](const Vec3& p) {
    return surface.nearest(p, kOpen * radius).distance > kOpen * radius;
  };
  if (!free(fit.point + radius * fit.normal)) return false;
  const Vec3 u = fit.normal.unitOrthogonal(), v = fit.normal.cross(u);
  const double may = kPatchSlope * radius + fit.slack + surface.skin();
  for (int i = 0; i < kPlaces; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kPlaces;
    const Vec3 beside = fit.point + radius * (std::cos(turn) * u + std::sin(turn) * v);
    const Height off = height_above(patch, Vec3::Zero(), beside);
    const Vec3 on = beside - off.height * off.normal;
    const auto nearest = surface.nearest(on, may);
    if (!(nearest.distance <= may)) return false;
    const Vec3 normal = side * triangle_normal(surface.mesh().corners(nearest.triangle));
    if (normal.dot(off.normal) < kFacing || !free(on + radius * off.normal)) return false;
  }
  return true;
}

/// Returns the height [m] of the contact surface above the triangles of the mesh.
double offset_of(const MeshOptions& options, double ball) {
  double offset = ball - options.grain.amplitude;
  if (options.height_map) offset -= options.height_map->mean();
  return offset;
}

/// Converts fits to patches. `end` [m] is the distance from the tool position to the first triangle
/// that no patch describes. A ball meets this triangle one radius earlier.
FittedPatches found(const MeshSurface& surface, double ball, const MeshFits& fits, double end,
                    double extent) {
  const MeshOptions& options = surface.options();
  const auto earlier = [&](double distance) { return std::max(0.0, distance - ball); };
  FittedPatches all;
  all.joined = fits.joined();
  all.faceted = true;
  all.rough = options.rough();
  all.offset = offset_of(options, ball);
  all.end = earlier(end);
  all.extent = extent;
  for (int i = 0; i < fits.count(); ++i) {
    const MeshFit& fit = fits[i];
    const std::uint32_t feature = feature_of(surface, fit);
    for (int j = 0; j < i; ++j)
      if (all.patches[static_cast<std::size_t>(j)].feature == feature) {
        all.end = earlier(fit.distance);  // A client cannot distinguish the two patches.
        return all;
      }
    all.patches[static_cast<std::size_t>(all.count++)] = {surface.mesh().origin() + fit.point,
                                                          fit.normal,
                                                          fit.axis,
                                                          fit.curvature,
                                                          earlier(fit.distance),
                                                          fit.slack,
                                                          feature};
  }
  return all;
}

double extent_of(const MeshSurface& surface, std::uint32_t t) {
  return std::min(kMostFitted, kFittedSides * side_of(surface.mesh().corners(t)));
}

/// Converts fits to patches. Extends the valid radius of a single patch that has no other triangle
/// and no border nearby.
FittedPatches reaching(const MeshSurface& surface, double ball, const MeshFits& fits,
                       const NearestSurface& nearest, const MeshFits::Other& other) {
  FittedPatches all = found(surface, ball, fits, other.distance, other.looked);
  constexpr double kLow = 0.75;  // largest height of the tool, as a share of the radius
  if (other.triangle != kNone || other.border || !(other.looked > 0.0)) return all;
  double radius = other.looked;
  while (2.0 * radius <= kMostFitted && holds_at(surface, fits[0], nearest.side, 2.0 * radius))
    radius *= 2.0;
  if (radius > other.looked && nearest.height < kLow * radius) {
    all.end = std::max(all.end, radius - ball);
    all.extent = radius;
    all.alone = true;
  }
  return all;
}

}  // namespace

FittedPatches mesh_patches(const MeshSurface& surface, Side felt_from, const Vec3& position,
                           const FeatureMemory& memory, double tool) noexcept {
  FittedPatches none;
  const Vec3 goal = position - surface.mesh().origin();
  const MeshOptions& options = surface.options();
  const double ball = options.radius + tool;
  const NearestSurface nearest = nearest_surface(surface, felt_from, goal, memory, ball);
  if (!(nearest.distance <= kMostFitted)) return none;
  none.end = std::max(0.0, nearest.distance - ball);
  if (nearest.side == 0.0) return none;

  const double extent = extent_of(surface, nearest.triangle);
  MeshFits planes(surface, nearest.side);
  MeshFit first = plane(surface, nearest.triangle, nearest.side, nearest.point);
  first.distance = nearest.distance;
  planes.add(first);
  MeshFits::Other other = planes.first_other(goal, nearest.height, extent);
  FittedPatches flat;
  if (other.triangle == kNone && !options.smooth) {
    flat = reaching(surface, ball, planes, nearest, other);
    if (other.border || 2.0 * flat.extent > kMostFitted) return flat;
  }

  MeshFits curve(surface, nearest.side);
  MeshFit fit = curved(surface, nearest);
  fit.distance = nearest.distance;
  curve.add(fit);
  const bool round = rolls(ball, fit.curvature);
  if (options.smooth && !round) return none;
  MeshFits::Other beyond;
  if (round) beyond = curve.first_other(goal, nearest.height, extent);
  if (flat.count > 0) {  // Fine facets may belong to a curved surface.
    if (!round || fit.curvature == 0.0) return flat;
    const FittedPatches bent = reaching(surface, ball, curve, nearest, beyond);
    return bent.end > flat.end ? bent : flat;
  }
  if (options.smooth || (round && beyond.triangle == kNone && beyond.distance > other.distance))
    return reaching(surface, ball, curve, nearest, beyond);

  while (other.triangle != kNone) {
    MeshFits more = planes;
    MeshFit next = plane(surface, other.triangle, nearest.side,
                         nearest_on_triangle(surface.mesh().corners(other.triangle), goal).point);
    next.distance = other.distance;
    if (!more.join(next)) break;
    const MeshFits::Other after = more.first_other(goal, nearest.height, extent);
    // Over a corner, all faces are equally near, so an equal distance is accepted.
    if (after.distance < other.distance) break;
    planes = more;
    other = after;
  }
  if (beyond.distance > other.distance) return found(surface, ball, curve, beyond.distance, extent);
  return found(surface, ball, planes, other.distance, extent);
}

FittedPatches mesh_mark(const MeshSurface& surface, Side felt_from, const Vec3& position,
                        const FeatureMemory& memory, double tool) noexcept {
  FittedPatches mark;
  mark.whole = true;
  const Vec3 goal = position - surface.mesh().origin();
  const double ball = surface.options().radius + tool;
  const NearestSurface nearest = nearest_surface(surface, felt_from, goal, memory, ball);
  if (!(nearest.distance <= kMostFitted)) return mark;
  // A tool behind a one-sided surface gets a patch that faces the felt side.
  const double side = nearest.side != 0.0 ? nearest.side : felt_from == Side::outside ? 1.0 : -1.0;
  FittedPatch& patch = mark.patches[0];
  patch.point = surface.mesh().origin() + nearest.point;
  patch.normal = memory.side != 0 && memory.feature != 0
                     ? memory.normal
                     : Vec3(side * triangle_normal(surface.mesh().corners(nearest.triangle)));
  patch.distance = std::max(0.0, nearest.distance - ball);
  patch.feature = 1;
  mark.count = 1;
  return mark;
}

double mesh_patch_radius(const MeshSurface& surface, const FittedPatches& fitted, int count,
                         int index, double tool) noexcept {
  const auto at = [&](int i) -> const FittedPatch& {
    return fitted.patches[static_cast<std::size_t>(i)];
  };
  const double ball = surface.options().radius + tool;
  // holds_at() has tested the surface up to this extent.
  if (fitted.alone && count == 1) return std::max(0.0, fitted.extent - ball);
  // The normal of the patch identifies the side that faces the tool.
  const Vec3 closest = at(index).point - surface.mesh().origin();
  const auto nearest = surface.nearest(closest, kMostFitted);
  if (!(nearest.distance <= kMostFitted)) return 0.0;
  const Vec3 normal = triangle_normal(surface.mesh().corners(nearest.triangle));
  const double looked = std::min(fitted.extent, extent_of(surface, nearest.triangle));
  MeshFits fits(surface, normal.dot(at(index).normal) < 0.0 ? -1.0 : 1.0);
  fits.set_joined(fitted.joined);
  for (int i = 0; i < count; ++i) {
    MeshFit fit;
    fit.point = at(i).point - surface.mesh().origin();
    fit.normal = at(i).normal;
    fit.axis = at(i).axis;
    fit.curvature = at(i).curvature;
    fit.slack = at(i).slack;
    fits.add(fit);
  }
  // Return the radius for a ball that touches the surface at `closest`.
  return std::max(
      0.0, fits.first_other(closest + ball * at(index).normal, ball, looked).distance - ball);
}

}  // namespace feltwire
