#include "sim/studies/scene/mesh_parts.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "core/base/text.hpp"
#include "core/convex/convex_hull.hpp"
#include "core/dynamics/mujoco_compile.hpp"
#include "core/dynamics/world.hpp"
#include "sim/measure/cost.hpp"

namespace feltwire {
namespace {

TriangleMesh refined_once(const TriangleMesh& mesh) {
  constexpr double kBend = 0.75;  // weight of `bent` in the new vertex; the rest is `flat`
  const MeshSurface surface{TriangleMesh(mesh), {.smooth = true}};
  TriangleSoup soup;
  for (const Vec3& v : mesh.vertices()) soup.vertices.push_back(mesh.origin() + v);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> known;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] =
        known.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(soup.vertices.size()));
    if (!is_new) return at->second;
    const Vec3 flat = 0.5 * (mesh.vertices()[a] + mesh.vertices()[b]);
    Vec3 bent = Vec3::Zero();
    for (const std::uint32_t end : {a, b}) {
      const Vec3 normal = surface.normal_at(end);
      bent += 0.5 * (flat - normal.dot(flat - mesh.vertices()[end]) * normal);
    }
    soup.vertices.push_back(mesh.origin() + (1.0 - kBend) * flat + kBend * bent);
    return at->second;
  };
  for (const Triangle& t : mesh.triangles()) {
    const std::uint32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
    for (const Triangle& part :
         {Triangle{t[0], a, c}, Triangle{a, t[1], b}, Triangle{c, b, t[2]}, Triangle{a, b, c}})
      soup.triangles.push_back(part);
  }
  return TriangleMesh(soup);
}

Object mesh_object(const char* name, const Shape& shape, const Vec3& position) {
  Object object;
  object.name = name;
  object.shape = shape;
  object.pose.position = position;
  object.material = {.stiffness = 500.0, .static_friction = 0.4, .dynamic_friction = 0.3};
  return object;
}

/// Returns the CPU time [us] of a simulation tick. The body has fallen on the still objects and is
/// at rest.
double tick_us(std::vector<Object> objects, Joint joint,
               const std::shared_ptr<const ConvexSolids>& solids) {
  constexpr std::size_t kSettle = 3000, kMeasured = 1000;
  constexpr double kWater = 1000.0, kNano = 1e-3;  // [kg/m^3] density; [us] per ns
  Body body;
  body.name = "body";
  body.density = kWater;
  body.pose = objects[1].pose;
  body.joint = joint;
  std::vector<std::shared_ptr<const ConvexSolids>> of_objects;
  of_objects.reserve(objects.size());
  for (const Object& object : objects)
    of_objects.push_back(std::holds_alternative<Mesh>(object.shape) ? solids : nullptr);
  const auto mechanism = compile(objects, {-1, 0}, {body}, {}, of_objects);
  Scene scene("parts", std::move(objects));
  scene.set_mechanism(mechanism);
  World world(scene);
  for (std::size_t i = 0; i < kSettle; ++i) world.step();
  return kNano * cost_ns(
                     1, [&](std::size_t) { world.step(); }, kMeasured);
}

TickCost tick_cost(const Shape& shape, double size,
                   const std::shared_ptr<const ConvexSolids>& solids) {
  const Vec3 above = size * Vec3::UnitZ();
  return {tick_us({mesh_object("floor", Plane{}, Vec3::Zero()), mesh_object("body", shape, above)},
                  Joint::free, solids),
          tick_us({mesh_object("like", shape, Vec3::Zero()), mesh_object("body", shape, above)},
                  Joint::slide, solids)};
}

}  // namespace

TriangleMesh refined(const TriangleMesh& mesh, int times) {
  TriangleMesh result = mesh;
  for (int i = 0; i < times; ++i) result = refined_once(result);
  return result;
}

std::vector<MeshParts> measure_parts(const TriangleMesh& mesh,
                                     const std::vector<DecompositionOptions>& options) {
  if (!mesh.report().closed() || !(mesh.report().volume > 0.0))
    throw std::invalid_argument(
        "the mesh bounds no solid: it is not closed, or its normals look inwards; mend it");
  const auto surface = std::make_shared<const MeshSurface>(TriangleMesh(mesh));
  std::vector<MeshParts> rows;
  for (const DecompositionOptions& own : options) {
    MeshParts row;
    row.options = own;
    const auto begin = std::chrono::steady_clock::now();
    const double cpu = process_seconds();
    row.parts = convex_parts(*surface, own);
    row.cpu = process_seconds() - cpu;
    row.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    for (const std::vector<Vec3>& part : row.parts.parts) {
      row.corners += part.size();
      if (const auto hull = convex_hull(part)) row.volume += hull->volume / mesh.report().volume;
    }
    row.tick = tick_cost(Mesh{surface}, mesh.report().size,
                         std::make_shared<const ConvexSolids>(row.parts.parts));
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string parts_table(const TriangleMesh& mesh, const std::vector<MeshParts>& rows) {
  constexpr double kMilli = 1e3;
  std::string text;
  append(text, "%zu triangles, %.4g mm along the longest side\n\n", mesh.triangles().size(),
         kMilli * mesh.report().size);
  text +=
      "tolerance  most  parts  corners  outside  volume   cut [s]          tick [us]\n"
      "[mm]                             [mm]              wall     CPU     on a floor  on its "
      "like\n";
  for (const MeshParts& row : rows)
    append(text, "%-9.3g  %4zu  %5zu  %7zu  %7.3g  %6.3f  %6.2f  %6.2f  %11.1f  %11.1f\n",
           kMilli * row.parts.tolerance, row.options.most, row.parts.parts.size(), row.corners,
           kMilli * row.parts.outside, row.volume, row.wall, row.cpu, row.tick.on_floor,
           row.tick.on_like);
  return text;
}

}  // namespace feltwire
