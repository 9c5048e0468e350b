// A mesh as patches: one that is curved as the normals about the point turn, or up to three planes
// with the edges between them; whichever reaches farther.
//
// What is claimed is checked on every triangle near: it lies on a patch and is not cut off by
// another, or it is hidden behind them, or the claim ends where it begins.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/contact/fitted_patches.hpp"
#include "core/contact/local_contact.hpp"
#include "core/geometry/mesh_surface.hpp"
#include "core/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kFacing = 0.5;  // cosine between a triangle's normal and its patch's, at least
constexpr double kFittedSides = 3.0;      // of the triangle it begins at: how far is looked
constexpr std::size_t kMostLooked = 256;  // triangles; where there are more, it is looked less far
// Facets that turn by no more than this [rad] are taken for a smooth surface cut up; the middle of
// an equilateral one stands kSagitta * angle * side off its corners' ball, of a lopsided one more.
constexpr double kMostTurned = 0.15, kSagitta = 0.25;
constexpr std::uint32_t kNone = TriangleMesh::kNone;

/// A patch, from the mesh's origin.
struct Fit {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  double slack = 0.0;              // [m] that facets stand off what they are cut from
  double distance = 0.0;           // [m]
  std::uint32_t triangle = kNone;  // that it was fitted to

  Vec3 way(const Vec3& p) const {
    const Vec3 d = p - point;
    return d - axis.dot(d) * axis;
  }
  /// As height_above() (local_contact.hpp), but for the root, which is near one where this is
  /// small.
  double height(const Vec3& p) const {
    const Vec3 d = way(p);
    return normal.dot(d) + 0.5 * curvature * d.squaredNorm();
  }
};

/// How a triangle lies to a patch: none of its corners before it, none behind it.
struct Lie {
  bool front = false, behind = false;  // some corner is; neither: it lies on the patch
  bool hidden = false;                 // all corners are behind, and what is between them
};

/// Whatever the patches are, a triangle's corners tell where it lies, and its middle, where patches
/// are curved.
Lie lie_of(const Fit& fit, const std::array<Vec3, 3>& corners, double skin) {
  Lie lie{.front = false, .behind = false, .hidden = true};
  // Between corners that are behind a hollow patch a triangle may come out of it.
  const double longest =
      std::max({(corners[1] - corners[0]).squaredNorm(), (corners[2] - corners[1]).squaredNorm(),
                (corners[0] - corners[2]).squaredNorm()});
  const double bulge = std::max(0.0, -0.5 * fit.curvature) * longest;
  const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3.0;
  for (const Vec3& p : {corners[0], corners[1], corners[2], middle}) {
    const double height = fit.height(p),
                 may = kPatchSlope * (p - fit.point).norm() + fit.slack + skin;
    lie.front |= height > may;
    lie.behind |= height < -may;
    lie.hidden &= height < -(may + bulge);
  }
  return lie;
}

double distance_to_edge(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 edge = b - a;
  const double part = std::clamp(edge.dot(p - a) / edge.squaredNorm(), 0.0, 1.0);
  return (a + part * edge - p).norm();
}

/// Where a triangle begins that the patches do not describe.
struct Other {
  double distance = 0.0;           // [m]
  std::uint32_t triangle = kNone;  // kNone: the border of the surface, or of what was looked at
};

class Fits {
 public:
  Fits(const MeshSurface& surface, double side) : surface_(&surface), side_(side) {}

  int count() const { return count_; }
  const Fit& operator[](int i) const { return fits_[static_cast<std::size_t>(i)]; }
  bool joined() const { return joined_; }
  void add(const Fit& fit) { fits_[static_cast<std::size_t>(count_++)] = fit; }
  void set_joined(bool joined) { joined_ = joined; }

  /// One plane more, if they meet in convex edges all or in hollow ones all.
  bool join(const Fit& fit) {
    if (count_ == kMaxPatches) return false;
    for (int i = 0; i < count_; ++i) {
      const Fit& other = (*this)[i];
      const Lie there = lie_of(other, corners(fit.triangle), surface_->skin());
      const Lie here = lie_of(fit, corners(other.triangle), surface_->skin());
      const bool convex = there.behind && !there.front && !here.front;
      const bool hollow = there.front && !there.behind && !here.behind;
      if (!convex && !hollow) return false;
      if (count_ > 1 && convex != joined_) return false;
      joined_ = convex;
    }
    add(fit);
    return true;
  }

  /// The nearest of a place `height` [m] off the surface, over an extent of it.
  Other first_other(const Vec3& center, double height, double extent) const {
    while (extent > surface_->skin()) {
      Other first{hypotenuse(height, extent), kNone};
      std::size_t looked = 0;
      surface_->tree().within(
          center, [&] { return looked > kMostLooked ? 0.0 : first.distance; },
          [&](std::uint32_t t) {
            if (++looked > kMostLooked) return;
            const Other other = beginning(t, center);
            if (other.distance < first.distance ||
                (other.distance == first.distance && other.triangle < first.triangle))
              first = other;
          });
      if (looked <= kMostLooked) return first;
      extent *= 0.5;
    }
    return {height, kNone};
  }

 private:
  std::array<Vec3, 3> corners(std::uint32_t t) const { return surface_->mesh().corners(t); }

  bool faces(const Fit& fit, const std::array<Vec3, 3>& c) const {
    const Vec3 normal = side_ * (c[1] - c[0]).cross(c[2] - c[0]);
    const Vec3 bent = fit.normal + fit.curvature * fit.way((c[0] + c[1] + c[2]) / 3.0);
    return normal.dot(bent) >= kFacing * normal.norm() * bent.norm();
  }

  Other beginning(std::uint32_t t, const Vec3& center) const {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const std::array<Vec3, 3> c = corners(t);
    std::array<Lie, kMaxPatches> lies;
    bool all_hidden = true, any_hidden = false;
    for (int i = 0; i < count_; ++i) {
      const Lie lie = lies[static_cast<std::size_t>(i)] = lie_of((*this)[i], c, surface_->skin());
      all_hidden &= lie.hidden;
      any_hidden |= lie.hidden;
    }
    // Nothing comes to where the patches are between it and the open.
    if (joined_ ? all_hidden : any_hidden) return {kNever, kNone};
    for (int i = 0; i < count_; ++i) {
      const Lie& on = lies[static_cast<std::size_t>(i)];
      if (on.front || on.behind || !faces((*this)[i], c)) continue;
      bool whole = true;
      for (int j = 0; j < count_; ++j) {
        const Lie& to = lies[static_cast<std::size_t>(j)];
        whole &= j == i || !(joined_ ? to.front : to.behind);
      }
      if (whole) return {border(t, c, center), kNone};
    }
    return {(nearest_on_triangle(c, center).point - center).norm(), t};
  }

  /// To an edge that the surface ends at.
  double border(std::uint32_t t, const std::array<Vec3, 3>& c, const Vec3& center) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
      if (surface_->mesh().neighbour(t, static_cast<int>(k)) == kNone)
        least = std::min(least, distance_to_edge(c[k], c[(k + 1) % 3], center));
    return least;
  }

  const MeshSurface* surface_;
  double side_;
  std::array<Fit, kMaxPatches> fits_{};
  int count_ = 0;
  bool joined_ = false;
};

/// Where a tool is to the surface.
struct Seat {
  Vec3 point = Vec3::Zero();
  std::uint32_t triangle = kNone;
  double side = 0.0;      // 0: none to speak of
  double distance = 0.0;  // [m] to the surface, 0 where it holds the tool
  double height = 0.0;    // [m] of the tool off the point, on either side
};

Seat seat_of(const MeshSurface& surface, Side felt_from, const Vec3& goal,
             const FeatureMemory& memory) {
  if (memory.side != 0)
    return {memory.proxy, memory.triangle, static_cast<double>(memory.side), 0.0,
            (goal - memory.proxy).norm()};
  const auto nearest = surface.nearest(goal, kMostFitted);
  Seat seat{nearest.point, nearest.triangle, 0.0, nearest.distance, nearest.distance};
  if (!(nearest.distance <= kMostFitted)) return seat;
  const double off = surface.side_of(goal, nearest);
  if (surface.options().double_sided)
    seat.side = off < 0.0 ? -1.0 : 1.0;
  else if (const double side = felt_from == Side::outside ? 1.0 : -1.0; side * off >= 0.0)
    seat.side = side;  // else it is behind, and nothing there holds it yet
  return seat;
}

Fit plane(const MeshSurface& surface, std::uint32_t t, double side, const Vec3& point) {
  Fit fit;
  fit.point = point;
  fit.normal = side * triangle_normal(surface.mesh().corners(t));
  fit.triangle = t;
  return fit;
}

/// [m] Near the length of an equilateral triangle's sides.
double side_of(const std::array<Vec3, 3>& c) {
  return std::sqrt((c[1] - c[0]).cross(c[2] - c[0]).norm());
}

/// As the normals of its corners turn (Rusinkiewicz 2004, of one triangle).
Fit curved(const MeshSurface& surface, const Seat& seat) {
  Fit fit = plane(surface, seat.triangle, seat.side, seat.point);
  const std::array<Vec3, 3> c = surface.mesh().corners(seat.triangle);
  const Triangle& corner = surface.mesh().triangles()[seat.triangle];
  std::array<Vec3, 3> normals;
  for (std::size_t k = 0; k < 3; ++k) normals[k] = seat.side * surface.normal_at(corner[k]);
  const Vec3 weights = nearest_on_triangle(c, seat.point).weights;
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
  const Bend bent = bend(u, v, turn(0, 0), 0.5 * (turn(0, 1) + turn(1, 0)), turn(1, 1));
  fit.normal = normal;
  fit.curvature = bent.curvature;
  fit.axis = bent.axis;
  const double side = side_of(c), turned = std::abs(bent.curvature) * side;
  if (turned < kMostTurned) fit.slack = kSagitta * turned * side;
  return fit;
}

/// The same for all triangles of one plane, and seldom for another's.
std::uint8_t feature_of(const Fit& fit) {
  constexpr double kSteps = 64.0;
  constexpr std::uint32_t kPrime = 2654435761u, kMost = 254;
  if (fit.curvature != 0.0) return 1;
  std::uint32_t hash = 0;
  for (const double x : fit.normal)
    hash = (hash + static_cast<std::uint32_t>(std::lround(kSteps * (x + 2.0)))) * kPrime;
  return static_cast<std::uint8_t>(2 + (hash >> 8) % kMost);
}

/// Beyond what was looked at triangle by triangle one patch is asked for at eight places of rings
/// that double: on the surface, and free above.
bool holds_at(const MeshSurface& surface, const Fit& fit, double side, double radius) {
  constexpr int kPlaces = 8;
  constexpr double kOpen = 0.75;  // of a radius above the patch that must be free
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

FittedPatches found(const MeshSurface& surface, const Fits& fits, double end, double extent) {
  FittedPatches all;
  all.joined = fits.joined();
  all.end = end;
  all.extent = extent;
  for (int i = 0; i < fits.count(); ++i) {
    const Fit& fit = fits[i];
    const std::uint8_t feature = feature_of(fit);
    for (int j = 0; j < i; ++j)
      if (all.patches[static_cast<std::size_t>(j)].feature == feature) {
        all.end = fit.distance;  // nobody could tell the two apart
        return all;
      }
    all.patches[static_cast<std::size_t>(all.count++)] = {surface.mesh().origin() + fit.point,
                                                          fit.normal,
                                                          fit.axis,
                                                          fit.curvature,
                                                          fit.distance,
                                                          fit.slack,
                                                          feature};
  }
  return all;
}

double extent_of(const MeshSurface& surface, std::uint32_t t) {
  return std::min(kMostFitted, kFittedSides * side_of(surface.mesh().corners(t)));
}

/// One patch to which nothing near was an exception: how much farther it holds.
FittedPatches reaching(const MeshSurface& surface, const Fits& fits, const Seat& seat,
                       const Other& other, double extent) {
  FittedPatches all = found(surface, fits, other.distance, extent);
  constexpr double kLow = 0.75;  // of the radius: higher than that the rings do not look
  if (other.distance < hypotenuse(seat.height, extent))
    return all;  // less was looked at, or it ends
  double radius = extent;
  while (2.0 * radius <= kMostFitted && holds_at(surface, fits[0], seat.side, 2.0 * radius))
    radius *= 2.0;
  if (radius > extent && seat.height < kLow * radius) {
    all.end = std::max(all.end, radius);
    all.extent = radius;
  }
  return all;
}

}  // namespace

FittedPatches mesh_patches(const MeshSurface& surface, Side felt_from, const Vec3& position,
                           const FeatureMemory& memory) noexcept {
  FittedPatches none;
  const Vec3 goal = position - surface.mesh().origin();
  const MeshOptions& options = surface.options();
  Seat seat = seat_of(surface, felt_from, goal, memory);
  if (!(seat.distance <= kMostFitted)) return none;
  none.end = std::max(0.0, seat.distance - options.radius);
  if (seat.side == 0.0 || options.radius > 0.0 || options.rough()) return none;

  const double extent = extent_of(surface, seat.triangle);
  Fits planes(surface, seat.side);
  Fit first = plane(surface, seat.triangle, seat.side, seat.point);
  first.distance = seat.distance;
  planes.add(first);
  Other other = planes.first_other(goal, seat.height, extent);
  if (other.triangle == kNone && !options.smooth)
    return reaching(surface, planes, seat, other, extent);

  Fits ball(surface, seat.side);
  Fit fit = curved(surface, seat);
  fit.distance = seat.distance;
  ball.add(fit);
  const Other beyond = ball.first_other(goal, seat.height, extent);
  if (options.smooth || (beyond.triangle == kNone && beyond.distance > other.distance))
    return reaching(surface, ball, seat, beyond, extent);

  while (other.triangle != kNone) {
    Fits more = planes;
    Fit next = plane(surface, other.triangle, seat.side,
                     nearest_on_triangle(surface.mesh().corners(other.triangle), goal).point);
    next.distance = other.distance;
    if (!more.join(next)) break;
    const Other after = more.first_other(goal, seat.height, extent);
    if (!(after.distance > other.distance)) break;
    planes = more;
    other = after;
  }
  if (beyond.distance > other.distance) return found(surface, ball, beyond.distance, extent);
  return found(surface, planes, other.distance, extent);
}

double mesh_patch_radius(const MeshSurface& surface, const FittedPatches& fitted, int count,
                         int index) noexcept {
  // Which side faces the tool, the patches' own normals say.
  const auto at = [&](int i) -> const FittedPatch& {
    return fitted.patches[static_cast<std::size_t>(i)];
  };
  const Vec3 center = at(index).point - surface.mesh().origin();
  const auto nearest = surface.nearest(center, kMostFitted);
  if (!(nearest.distance <= kMostFitted)) return 0.0;
  const Vec3 normal = triangle_normal(surface.mesh().corners(nearest.triangle));
  const double looked = std::min(fitted.extent, extent_of(surface, nearest.triangle));
  Fits fits(surface, normal.dot(at(index).normal) < 0.0 ? -1.0 : 1.0);
  fits.set_joined(fitted.joined);
  for (int i = 0; i < count; ++i) {
    Fit fit;
    fit.point = at(i).point - surface.mesh().origin();
    fit.normal = at(i).normal;
    fit.axis = at(i).axis;
    fit.curvature = at(i).curvature;
    fit.slack = at(i).slack;
    fits.add(fit);
  }
  const double near = fits.first_other(center, 0.0, looked).distance;
  return near < looked ? near : fitted.extent;  // what is beyond was asked for on rings
}

}  // namespace feltwire
