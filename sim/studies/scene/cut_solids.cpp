#include "sim/studies/scene/cut_solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/convex/decomposition.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/polyhedra/polyhedron.hpp"
#include "scenes/bunny_text.hpp"
#include "sim/studies/scene/finer_surface.hpp"

namespace feltwire {
namespace {

using Flat = Eigen::Vector2d;

/// Returns the corners of a prism over a polygon in x and y, from -`half` to `half` in z.
std::vector<Vec3> prism(const std::vector<Flat>& polygon, double half) {
  std::vector<Vec3> corners;
  for (const double z : {-half, half})
    for (const Flat& p : polygon) corners.emplace_back(p.x(), p.y(), z);
  return corners;
}

Flat at_angle(double radius, double angle) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Returns the outline of a tooth that points along x. The outline is counter-clockwise: up one
/// flank and down the other.
std::vector<Flat> tooth(const GearShape& gear) {
  constexpr double kPressure = std::numbers::pi / 9.0;  // [rad] pressure angle
  // [modules] Depth of the root below, and height of the tip above the pitch circle.
  constexpr double kRoot = 1.25, kTip = 1.0;
  constexpr int kFlank = 4;  // number of straight segments of an involute
  const double pitch = gear.pitch_radius(), base = pitch * std::cos(kPressure);
  const double root = pitch - kRoot * gear.module, tip = pitch + kTip * gear.module;
  const auto involute = [](double angle) { return std::tan(angle) - angle; };
  const double half_tooth = std::numbers::pi / (2.0 * gear.teeth) - 0.5 * gear.backlash / pitch;
  const auto half_angle = [&](double radius) {
    return half_tooth + involute(kPressure) - involute(std::acos(base / radius));
  };
  std::vector<Flat> lower = {at_angle(root, -half_angle(base))};
  for (int i = 0; i <= kFlank; ++i) {
    const double radius = base + (tip - base) * i / kFlank;
    lower.push_back(at_angle(radius, -half_angle(radius)));
  }
  std::vector<Flat> all = lower;
  for (std::size_t i = lower.size(); i-- > 0;) all.emplace_back(lower[i].x(), -lower[i].y());
  return all;
}

/// Adds the side walls of a prism to `soup`. The vertices of the lower polygon begin at the index
/// `low`, and the vertices of the upper polygon at `high`. If the polygon is counter-clockwise as
/// seen from above, the walls face outwards.
void add_walls(std::uint32_t low, std::uint32_t high, std::uint32_t count, TriangleSoup& soup) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    soup.triangles.push_back({low + i, low + next, high + next});
    soup.triangles.push_back({low + i, high + next, high + i});
  }
}

std::vector<Vec3> box_corners(const Vec3& least, const Vec3& most) {
  constexpr int kCorners = 8;
  std::vector<Vec3> corners;
  corners.reserve(kCorners);
  for (int i = 0; i < kCorners; ++i)
    corners.emplace_back((i & 1) != 0 ? most.x() : least.x(), (i & 2) != 0 ? most.y() : least.y(),
                         (i & 4) != 0 ? most.z() : least.z());
  return corners;
}

}  // namespace

CutSolid box_solid(const Vec3& half) {
  constexpr int kUnused = 3;  // number of segments of a circle; a box has no circles
  return {tessellate(Box{half}, kUnused), {box_corners(-half, half)}};
}

CutSolid gear_solid(const GearShape& gear) {
  const double half = 0.5 * gear.width;
  CutSolid solid;
  std::vector<Flat> outline, hub;
  for (int i = 0; i < gear.teeth; ++i) {
    const Eigen::Rotation2Dd turn(2.0 * std::numbers::pi * i / gear.teeth);
    std::vector<Flat> own = tooth(gear);
    for (Flat& p : own) p = turn * p;
    hub.push_back(own.front());
    hub.push_back(own.back());
    outline.insert(outline.end(), own.begin(), own.end());
    solid.parts.push_back(prism(own, half));
  }
  solid.parts.push_back(prism(hub, half));
  TriangleSoup& soup = solid.surface;
  soup.vertices = prism(outline, half);
  const auto count = static_cast<std::uint32_t>(outline.size());
  const std::uint32_t axis = 2 * count, own = count / static_cast<std::uint32_t>(gear.teeth);
  soup.vertices.emplace_back(0.0, 0.0, -half);
  soup.vertices.emplace_back(0.0, 0.0, half);
  add_walls(0, count, count, soup);
  // Close both ends with triangles. The triangles of the hub have a corner on the axis, and the
  // triangles of a tooth have a corner at its first root vertex.
  const auto add_ends = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    soup.triangles.push_back({a, c, b});
    soup.triangles.push_back({a == axis ? axis + 1 : count + a, count + b, count + c});
  };
  for (std::uint32_t root = 0; root < count; root += own) {
    for (std::uint32_t i = root + 1; i + 1 < root + own; ++i) add_ends(root, i, i + 1);
    add_ends(axis, root, root + own - 1);
    add_ends(axis, root + own - 1, (root + own) % count);
  }
  return solid;
}

CutSolid link_solid(const LinkShape& link) {
  const double x = 0.5 * link.length, y = 0.5 * link.width, half = 0.5 * link.bar;
  const double in_x = x - link.bar, in_y = y - link.bar;
  CutSolid solid;
  solid.parts = {box_corners(Vec3(-x, in_y, -half), Vec3(x, y, half)),
                 box_corners(Vec3(-x, -y, -half), Vec3(x, -in_y, half)),
                 box_corners(Vec3(in_x, -in_y, -half), Vec3(x, in_y, half)),
                 box_corners(Vec3(-x, -in_y, -half), Vec3(-in_x, in_y, half))};
  const std::vector<Flat> outer = {{-x, -y}, {x, -y}, {x, y}, {-x, y}},
                          inner = {{-in_x, -in_y}, {in_x, -in_y}, {in_x, in_y}, {-in_x, in_y}};
  TriangleSoup& soup = solid.surface;
  soup.vertices = prism(outer, half);
  const std::vector<Vec3> within = prism(inner, half);
  soup.vertices.insert(soup.vertices.end(), within.begin(), within.end());
  constexpr std::uint32_t kSides = 4, kInner = 8;
  add_walls(0, kSides, kSides, soup);
  add_walls(kInner + kSides, kInner, kSides, soup);  // indices exchanged: these walls face the axis
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const std::uint32_t next = (i + 1) % kSides;
    for (const std::uint32_t up : {0U, kSides}) {
      const std::uint32_t a = up + i, b = up + next, c = kInner + b, d = kInner + a;
      if (up == 0) {
        soup.triangles.push_back({a, c, b});
        soup.triangles.push_back({a, d, c});
      } else {
        soup.triangles.push_back({a, b, c});
        soup.triangles.push_back({a, c, d});
      }
    }
  }
  return solid;
}

CutSolid bunny_solid(double tolerance, std::size_t triangles) {
  constexpr double kCentimetre = 0.01;  // [m] length unit of the file
  constexpr double kLeftOut = 0.25;     // ratio of the tolerance for corners to that for parts
  CutSolid solid;
  solid.surface = finer_surface(parse_mesh(embedded::bunny, "bunny.obj", kCentimetre), triangles);
  Vec3 least = solid.surface.vertices.front(), most = least;
  for (const Vec3& v : solid.surface.vertices) {
    least = least.cwiseMin(v);
    most = most.cwiseMax(v);
  }
  for (Vec3& v : solid.surface.vertices) v -= 0.5 * (least + most);
  const MeshSurface surface{TriangleMesh(solid.surface)};
  for (const auto& part : convex_parts(surface, {.tolerance = tolerance}).parts) {
    auto corners = fewer_corners(part, kLeftOut * tolerance);
    for (Vec3& corner : corners) corner += surface.mesh().origin();
    solid.parts.push_back(std::move(corners));
  }
  return solid;
}

}  // namespace feltwire
