#include "core/prefetched_geometry/trial_ways.hpp"

#include <algorithm>
#include <limits>

#include "core/base/numeric.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

/// A point on a mesh [m, from the mesh's origin], and the units of work of a query at this point.
struct Place {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  std::uint64_t crowd = 0;
};

/// Returns the units of work of a tree query at one point.
std::uint64_t crowd_at(const MeshSurface& surface, const Vec3& p) {
  WorkLimit work(WorkLimit::kUnlimited);
  Bounds here;
  here.add(p);
  surface.tree().overlapping(
      here, [](std::uint32_t) {}, &work);
  return work.done();
}

Place on_triangle(const MeshSurface& surface, std::uint32_t t, const Vec3& p) {
  return {p, triangle_normal(surface.mesh().corners(t)), crowd_at(surface, p)};
}

/// Returns the corner with the most triangles around it. A walk around this corner visits all of
/// them.
Place at_fullest_corner(const MeshSurface& surface) {
  const TriangleMesh& mesh = surface.mesh();
  std::uint32_t fullest = 0;
  for (std::uint32_t v = 1; v < mesh.vertices().size(); ++v)
    if (mesh.around(v).size() > mesh.around(fullest).size()) fullest = v;
  Place place = on_triangle(surface, mesh.around(fullest).front(), mesh.vertices()[fullest]);
  place.crowd = std::max<std::uint64_t>(place.crowd, mesh.around(fullest).size());
  return place;
}

std::vector<Place> places_of(const MeshSurface& surface) {
  constexpr std::size_t kTried = 64;
  const TriangleMesh& mesh = surface.mesh();
  const std::size_t count = mesh.triangles().size(),
                    step = std::max<std::size_t>(1, count / kTried);
  std::vector<Place> places = {at_fullest_corner(surface)};
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < count; i += step) {
    const auto t = static_cast<std::uint32_t>(i);
    const auto c = mesh.corners(t);
    const Vec3 middle = (c[0] + c[1] + c[2]) / 3.0;
    places.push_back(on_triangle(surface, t, middle));
    sum += middle;
  }
  const Vec3 mean = sum / static_cast<double>(places.size() - 1);
  for (const Vec3& p : {Vec3(Vec3::Zero()), mean}) {
    const auto nearest = surface.nearest(p, std::numeric_limits<double>::infinity());
    places.push_back(on_triangle(surface, nearest.triangle, nearest.point));
  }
  return places;
}

Vec3 across(const Vec3& normal) {
  Eigen::Index axis;
  normal.cwiseAbs().minCoeff(&axis);
  return direction(Vec3(normal.cross(Vec3::Unit(axis))));
}

/// Returns the distance [m] from the centre of the solid to its farthest point, or 0 if the solid
/// is unbounded.
double reach_of(const SolidData& solid) {
  double reach = 0.0;
  for (const Vec3& p : solid.mesh.vertices) reach = std::max(reach, length(p));
  if (!solid.mesh.triangles.empty()) return reach;
  return on_primitive(
      solid.shape, [](const auto& shape) { return is_bounded(shape) ? shape.reach() : 0.0; },
      [] { return 0.0; });
}

}  // namespace

std::vector<TrialWay> mesh_ways(const Object& object, std::uint16_t index) {
  // [m] height of the start, depth of the end, movement along the surface
  constexpr double kAbove = 2e-3, kBelow = 4e-3, kAlong = 8e-3;
  const MeshSurface& surface = *std::get<Mesh>(object.shape).surface;
  std::vector<Place> places = places_of(surface);
  // Take the points with the most work, and as many other points, evenly spread.
  std::ranges::stable_sort(places, std::ranges::greater(), &Place::crowd);
  const std::size_t crowded = std::min(places.size(), kMostMeshWays / 2);
  std::vector<Place> chosen(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(crowded));
  const std::size_t rest = places.size() - crowded;
  const std::size_t step = std::max<std::size_t>(1, rest / (kMostMeshWays / 2));
  for (std::size_t i = crowded; i < places.size() && chosen.size() < kMostMeshWays; i += step)
    chosen.push_back(places[i]);

  std::vector<TrialWay> ways;
  const double side = object.felt_from == Side::inside ? -1.0 : 1.0;
  const double radius = surface.options().radius;
  for (const Place& place : chosen) {
    const auto world = [&](const Vec3& p) {
      return Vec3(object.pose.position + object.pose.orientation * (surface.mesh().origin() + p));
    };
    const Vec3 out = side * place.normal;
    const Vec3 into = place.point + (radius - kBelow) * out;
    ways.push_back({index, world(place.point + (radius + kAbove) * out), world(into),
                    world(into + kAlong * across(out))});
  }
  return ways;
}

std::vector<TrialWay> body_ways(const std::vector<SolidData>& solids, double radius) {
  // [m] distance from the start to the solid, movement perpendicular to the axis
  constexpr double kApart = 0.01, kAlong = 8e-3;
  constexpr std::size_t kAxes = 3, kMostSolids = kMostBodyWays / kAxes - 1;
  std::vector<TrialWay> ways;
  if (solids.empty()) return ways;
  const auto add = [&](const SolidData& solid, const Vec3& middle, double reach) {
    for (int axis = 2; axis >= 0; --axis) {
      const Vec3 out = solid.pose.orientation * Vec3(Vec3::Unit(axis));
      const Vec3 far = middle + (reach + radius + kApart) * out;
      const Vec3 from = solid.from_inside ? middle : far, into = solid.from_inside ? far : middle;
      ways.push_back({solid.object, from, into, into + kAlong * across(out)});
    }
  };
  const std::size_t step = (solids.size() + kMostSolids - 1) / kMostSolids;
  for (std::size_t i = 0; i < solids.size(); i += step)
    add(solids[i], solids[i].pose.position, reach_of(solids[i]));

  Vec3 sum = Vec3::Zero();
  for (const SolidData& solid : solids) sum += solid.pose.position;
  const Vec3 middle = sum / static_cast<double>(solids.size());
  const auto off = [&](const SolidData& solid) {
    return length(Vec3(solid.pose.position - middle));
  };
  double reach = 0.0;
  for (const SolidData& solid : solids) reach = std::max(reach, off(solid) + reach_of(solid));
  add(*std::ranges::min_element(solids, {}, off), middle, reach);
  return ways;
}

}  // namespace feltwire
