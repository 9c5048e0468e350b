// Describes a distance grid as one patch. The patch has the curvature of the distance field. Rings
// of eight test points around the patch's point show how far the patch is valid. Each ring has
// twice the radius of the previous ring. A spike that is thinner than the gaps between the test
// points is found only when the tool is nearer.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/numeric.hpp"
#include "core/grid/distance_grid.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"

namespace feltwire {
namespace {

constexpr int kNewton = 4;          // number of Newton steps to the surface
constexpr int kGridPlaces = 8;      // number of test points on a ring
constexpr double kFirstRing = 2.0;  // radius of the first ring, in grid steps
// Least distance from the surface, as a share of the height above the patch.
constexpr double kGridOpen = 0.75;
// Depth of the test below the patch, as a share of the ring's radius.
constexpr double kGridDeep = 0.25;
// Largest ratio of the tool's distance from the found point to the distance in the field.
constexpr double kStraight = 1.1;

/// The surface point at the end of the descent along the gradient.
struct GridClosest {
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  double slope = 0.0;  // length of the gradient
  bool found = false;
};

GridClosest closest_on(const DistanceGrid<float>& field, double sign, const Vec3& position) {
  GridClosest closest{.point = position, .normal = Vec3::Zero(), .slope = 0.0, .found = false};
  for (int i = 0; i < kNewton; ++i) {
    const FieldPoint here = field.at(closest.point);
    closest.slope = length(here.gradient);
    if (!(closest.slope > 0.0) || !std::isfinite(here.distance)) return closest;
    closest.normal = sign * here.gradient / closest.slope;
    closest.point -= sign * here.distance / closest.slope * closest.normal;
  }
  closest.found = std::abs(field.at(closest.point).distance) <= kPatchSlope * field.resolution();
  return closest;
}

/// Returns the curvature of the surface, from differences of the normal over one grid step to each
/// side.
LocalCurvature curvature_at(const DistanceGrid<float>& field, double sign,
                            const GridClosest& closest) {
  const Vec3 u = closest.normal.unitOrthogonal(), v = closest.normal.cross(u);
  const double h = field.resolution();
  const auto turn = [&](const Vec3& way) {
    return Vec3(
        sign / (2.0 * h * closest.slope) *
        (field.at(closest.point + h * way).gradient - field.at(closest.point - h * way).gradient));
  };
  const Vec3 along_u = turn(u), along_v = turn(v);
  return local_curvature(u, v, along_u.dot(u), 0.5 * (along_u.dot(v) + along_v.dot(u)),
                         along_v.dot(v));
}

/// Returns true if the field agrees with the patch at three points along a normal: on the surface,
/// inside at the depth `deep`, and outside at the height `radius`.
bool holds_along(const DistanceGrid<float>& field, double sign, const Vec3& on, const Vec3& normal,
                 double radius, double deep) {
  const double may = kPatchSlope * (radius + field.resolution());
  // Beyond its band, a field gives only a lower bound of the distance.
  const double open = std::min(kGridOpen * radius, field.band());
  return std::abs(field.at(on).distance) <= may &&
         std::abs(sign * field.at(on - deep * normal).distance + deep) <= may &&
         sign * field.at(on + radius * normal).distance >= open;
}

/// Returns true if the patch is valid within `radius` [m] for a tool at the depth `depth` [m].
bool holds(const DistanceGrid<float>& field, double sign, const SurfacePatch& patch, double radius,
           double depth) {
  const Vec3 u = patch.normal.unitOrthogonal(), v = patch.normal.cross(u);
  const double deep = std::min(std::max(depth, kGridDeep * radius), kGridOpen * field.band());
  if (!holds_along(field, sign, patch.point, patch.normal, radius, deep)) return false;
  for (int i = 0; i < kGridPlaces; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kGridPlaces;
    const Vec3 beside = patch.point + radius * (std::cos(turn) * u + std::sin(turn) * v);
    const Height off = height_above(patch, Vec3::Zero(), beside);
    if (!holds_along(field, sign, beside - off.height * off.normal, off.normal, radius, deep))
      return false;
  }
  return true;
}

}  // namespace

FittedPatches grid_patches(const Grid& grid, Side felt_from, const Vec3& position,
                           double ball) noexcept {
  const DistanceGrid<float>& field = *grid.field;
  const double sign = felt_from == Side::outside ? 1.0 : -1.0;
  FittedPatches all;
  const auto earlier = [&](double distance) { return std::max(0.0, distance - ball); };
  all.end = earlier(field.at_least(position, sign, std::numeric_limits<double>::infinity()));
  const double distance = sign * field.at(position).distance;
  if (!(distance < field.band() && -distance < kGridOpen * field.band())) return all;
  const GridClosest closest = closest_on(field, sign, position);
  const double height = length(Vec3(position - closest.point));
  if (!closest.found || height > kStraight * std::abs(distance) + field.resolution()) return all;

  const LocalCurvature bent = curvature_at(field, sign, closest);
  if (!rolls(ball, bent.curvature)) return all;
  SurfacePatch patch;
  patch.point = closest.point;
  patch.normal = closest.normal;
  patch.curvature = bent.curvature;
  patch.axis = bent.axis;
  double radius = 0.0;
  for (double r = kFirstRing * field.resolution();
       r <= kMostFitted && holds(field, sign, patch, r, -distance); r *= 2.0)
    radius = r;
  if (!(height < kGridOpen * radius)) return all;
  all.end = earlier(radius);
  all.extent = radius;
  all.offset = ball;
  all.count = 1;
  all.patches[0] = {patch.point,       patch.normal, patch.axis, patch.curvature,
                    earlier(distance), 0.0,          1};
  return all;
}

}  // namespace feltwire
