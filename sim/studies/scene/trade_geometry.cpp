#include "sim/studies/scene/trade_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/splitmix.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_contact.hpp"
#include "core/mesh/tessellation.hpp"
#include "sim/measure/cost.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/measure/glide.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kScattered = 1 << 14;  // number of scattered positions
constexpr std::size_t kScatterLaps = 9;

using Field = std::function<FieldPoint(const Vec3&)>;

std::vector<Vec3> scattered() {
  std::vector<Vec3> places;
  for (std::uint64_t i = 0; places.size() < kScattered; ++i) {
    Vec3 p;
    for (std::uint64_t axis = 0; axis < 3; ++axis)
      p[static_cast<Eigen::Index>(axis)] =
          static_cast<double>(splitmix::draw(1, 3 * i + axis) >> 11) * 0x1p-52 - 1.0;
    if (p.norm() > 0.1 && p.norm() < 1.0)
      places.push_back((kGlideBall - kGlideDepth) * p.normalized());
  }
  return places;
}

/// Returns the contact force [N] at a point of a distance field: -k d grad d, with the distance d.
Vec3 force(const FieldPoint& field) { return -kGlideStiffness * field.distance * field.gradient; }

/// Measures the errors and the time of `field` along a path. Also measures the time of
/// `scattered_field` at scattered positions, where the last query does not help the next one.
void measure(const Field& field, const Field& scattered_field, GeometryCell& cell) {
  const auto path = glide();
  double error = 0.0, whole = 0.0;
  std::vector<double> angles;
  Vec3 last = Vec3::Zero(), last_exact = Vec3::Zero();
  for (std::size_t n = 0; n < path.size(); ++n) {
    const Vec3 exact = kGlideStiffness * kGlideDepth * path[n].normalized();
    const Vec3 felt = force(field(path[n]));
    angles.push_back(angle_between(felt, exact));
    error += (felt - exact).squaredNorm();
    whole += exact.squaredNorm();
    if (n > 0) cell.jump = std::max(cell.jump, (felt - last).norm() - (exact - last_exact).norm());
    last = felt;
    last_exact = exact;
  }
  const Spread directions = spread(std::move(angles));
  cell.direction_error = directions.mean;
  cell.worst_direction = directions.max;
  cell.force_error = std::sqrt(error / whole);

  const auto places = scattered();
  volatile double kept = 0.0;  // so that the compiler does not remove the work
  double sum = 0.0;
  cell.glide_ns = cost_ns(path.size(), [&](std::size_t i) { sum += field(path[i]).distance; });
  cell.scattered_ns = cost_ns(
      places.size(), [&](std::size_t i) { sum += scattered_field(places[i]).distance; },
      kScatterLaps);
  kept = sum;
  static_cast<void>(kept);
}

void measure(const Field& field, GeometryCell& cell) { measure(field, field, cell); }

GeometryCell analytic() {
  GeometryCell cell;
  cell.kind = "analytic";
  cell.arithmetic = "double";
  cell.bytes = sizeof(Sphere);
  const Sphere ball{kGlideBall};
  measure([ball](const Vec3& p) { return signed_distance(ball, Side::outside, p); }, cell);
  return cell;
}

GeometryCell analytic_float() {
  GeometryCell cell;
  cell.kind = "analytic";
  cell.arithmetic = "float";
  cell.bytes = sizeof(float);
  measure(
      [](const Vec3& p) {
        const Vector3<float> at = p.cast<float>();
        const float distance = at.norm();
        return FieldPoint{static_cast<double>(distance - static_cast<float>(kGlideBall)),
                          (at / distance).cast<double>()};
      },
      cell);
  return cell;
}

GeometryCell mesh_cell(const char* kind, const TriangleSoup& soup) {
  GeometryCell cell;
  cell.kind = kind;
  cell.arithmetic = "double";
  cell.size = static_cast<double>(soup.triangles.size());
  return cell;
}

GeometryCell nearest_on_mesh(int level) {
  const TriangleSoup soup = icosphere(kGlideBall, level);
  GeometryCell cell = mesh_cell("mesh, nearest", soup);
  const double start = process_seconds();
  const MeshSurface surface{TriangleMesh(soup)};
  cell.build = process_seconds() - start;
  cell.bytes = static_cast<double>(surface.memory());
  measure(
      [&](const Vec3& position) {
        const Vec3 p = position - surface.mesh().origin();
        const auto nearest = surface.nearest(p, std::numeric_limits<double>::infinity());
        const double distance =
            surface.side_of(p, nearest) < 0.0 ? -nearest.distance : nearest.distance;
        return FieldPoint{distance, Vec3((p - nearest.point) / distance)};
      },
      cell);
  return cell;
}

Vec3 in_float(const Vec3& v) { return v.cast<float>().cast<double>(); }

/// Measures the god-object method. On the path, each query starts at the last position of the
/// proxy. At scattered positions, each query starts without an earlier proxy. `rounded`: the
/// vertices and the tool's positions have float precision.
GeometryCell proxy_on_mesh(int level, bool rounded) {
  TriangleSoup soup = icosphere(kGlideBall, level);
  if (rounded)
    for (Vec3& v : soup.vertices) v = in_float(v);
  GeometryCell cell = mesh_cell("mesh, proxy", soup);
  if (rounded) cell.arithmetic = "float";
  const double start = process_seconds();
  const MeshSurface surface{TriangleMesh(soup)};
  cell.build = process_seconds() - start;
  cell.bytes = static_cast<double>(surface.memory());
  const auto answer = [&](const Vec3& p, FeatureMemory& memory) {
    const SurfacePoint proxy =
        mesh_surface_point(surface, Side::outside, rounded ? in_float(p) : p, memory);
    return FieldPoint{-proxy.depth, proxy.normal};
  };
  FeatureMemory memory;
  measure([&](const Vec3& p) { return answer(p, memory); },
          [&](const Vec3& p) {
            FeatureMemory anew;
            return answer(p, anew);
          },
          cell);
  return cell;
}

template <class Real>
GeometryCell sampled(const char* kind, Interpolation interpolation, double resolution) {
  GeometryCell cell;
  cell.kind = kind;
  cell.arithmetic = sizeof(Real) == sizeof(float) ? "float" : "double";
  cell.size = resolution;
  const double start = process_seconds();
  const DistanceGrid<Real> grid(solid_of(Shape(Sphere{kGlideBall})),
                                {.resolution = resolution, .interpolation = interpolation});
  cell.build = process_seconds() - start;
  cell.bytes = static_cast<double>(grid.bytes());
  measure([&](const Vec3& p) { return grid.at(p); }, cell);
  return cell;
}

}  // namespace

std::vector<GeometryCell> run_trade_geometry(const GeometryGrid& grid) {
  std::vector<GeometryCell> cells = {analytic(), analytic_float()};
  for (const int level : grid.levels) cells.push_back(nearest_on_mesh(level));
  for (const bool rounded : {false, true})
    for (const int level : grid.levels) cells.push_back(proxy_on_mesh(level, rounded));
  for (const double h : grid.resolutions)
    cells.push_back(sampled<float>("grid, linear", Interpolation::linear, h));
  for (const double h : grid.resolutions)
    cells.push_back(sampled<float>("grid, quadratic", Interpolation::quadratic, h));
  for (const double h : grid.resolutions)
    cells.push_back(sampled<double>("grid, quadratic", Interpolation::quadratic, h));
  return cells;
}

}  // namespace feltwire
