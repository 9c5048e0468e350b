#include "sim/trade_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/geometry/mesh_distance.hpp"
#include "core/geometry/signed_distance.hpp"
#include "core/geometry/tessellation.hpp"
#include "core/splitmix.hpp"
#include "sim/cost.hpp"
#include "sim/metrics.hpp"

namespace feltwire {
namespace {

constexpr double kRadius = 0.09, kDepth = 2e-3;  // [m]
constexpr double kStiffness = 5000.0;            // [N/m]
constexpr double kSpeed = 0.1, kPeriod = 1e-3;   // [m/s], [s]
constexpr std::size_t kScattered = 1 << 14;      // places
constexpr std::size_t kScatterLaps = 9;

using Field = std::function<FieldPoint(const Vec3&)>;

std::vector<Vec3> glide() {
  const Vec3 u = Vec3(1.0, 0.3, 0.2).normalized();
  const Vec3 v = u.cross(Vec3(-0.2, 0.5, 1.0)).normalized();
  const double r = kRadius - kDepth, turn = 2.0 * std::numbers::pi;
  const auto samples = static_cast<std::size_t>(turn * r / (kSpeed * kPeriod));
  std::vector<Vec3> path;
  for (std::size_t n = 0; n < samples; ++n) {
    const double angle = turn * static_cast<double>(n) / static_cast<double>(samples);
    path.push_back(r * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return path;
}

std::vector<Vec3> scattered() {
  std::vector<Vec3> places;
  for (std::uint64_t i = 0; places.size() < kScattered; ++i) {
    Vec3 p;
    for (std::uint64_t axis = 0; axis < 3; ++axis)
      p[static_cast<Eigen::Index>(axis)] =
          static_cast<double>(splitmix::draw(1, 3 * i + axis) >> 11) * 0x1p-52 - 1.0;
    if (p.norm() > 0.1 && p.norm() < 1.0) places.push_back((kRadius - kDepth) * p.normalized());
  }
  return places;
}

/// [N] as the point's contact with a grid has it: -k d grad d.
Vec3 force(const FieldPoint& field) { return -kStiffness * field.distance * field.gradient; }

void measure(const Field& field, GeometryCell& cell) {
  const auto path = glide();
  double error = 0.0, whole = 0.0;
  std::vector<double> angles;
  Vec3 last = Vec3::Zero(), last_exact = Vec3::Zero();
  for (std::size_t n = 0; n < path.size(); ++n) {
    const Vec3 exact = kStiffness * kDepth * path[n].normalized();
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
  volatile double kept = 0.0;  // or the compiler leaves out what nobody wants
  double sum = 0.0;
  cell.glide_ns = cost_ns(path.size(), [&](std::size_t i) { sum += field(path[i]).distance; });
  cell.scattered_ns = cost_ns(
      places.size(), [&](std::size_t i) { sum += field(places[i]).distance; }, kScatterLaps);
  kept = sum;
  static_cast<void>(kept);
}

double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

GeometryCell analytic() {
  GeometryCell cell;
  cell.kind = "analytic";
  cell.arithmetic = "double";
  cell.bytes = sizeof(Sphere);
  const Sphere ball{kRadius};
  measure([ball](const Vec3& p) { return signed_distance(ball, Side::outside, p); }, cell);
  return cell;
}

GeometryCell mesh(int level) {
  GeometryCell cell;
  cell.kind = "mesh";
  cell.arithmetic = "double";
  const TriangleSoup soup = icosphere(kRadius, level);
  cell.size = static_cast<double>(soup.triangles.size());
  const double start = process_seconds();
  const MeshField field = field_of(TriangleMesh(soup));
  cell.build = process_seconds() - start;
  cell.bytes = static_cast<double>(field.bytes);
  measure(field.at, cell);
  return cell;
}

template <class Real>
GeometryCell sampled(const char* kind, Interpolation interpolation, double resolution) {
  GeometryCell cell;
  cell.kind = kind;
  cell.arithmetic = sizeof(Real) == sizeof(float) ? "float" : "double";
  cell.size = resolution;
  const double start = process_seconds();
  const DistanceGrid<Real> grid(solid_of(Shape(Sphere{kRadius})),
                                {.resolution = resolution, .interpolation = interpolation});
  cell.build = process_seconds() - start;
  cell.bytes = static_cast<double>(grid.bytes());
  measure([&](const Vec3& p) { return grid.at(p); }, cell);
  return cell;
}

}  // namespace

std::vector<GeometryCell> run_trade_geometry(const GeometryGrid& grid) {
  std::vector<GeometryCell> cells = {analytic()};
  for (const int level : grid.levels) cells.push_back(mesh(level));
  for (const double h : grid.resolutions)
    cells.push_back(sampled<float>("grid, linear", Interpolation::linear, h));
  for (const double h : grid.resolutions)
    cells.push_back(sampled<float>("grid, quadratic", Interpolation::quadratic, h));
  for (const double h : grid.resolutions)
    cells.push_back(sampled<double>("grid, quadratic", Interpolation::quadratic, h));
  return cells;
}

}  // namespace feltwire
