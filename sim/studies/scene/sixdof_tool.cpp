#include "sim/studies/scene/sixdof_tool.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>

#include "core/dynamics/mass_properties.hpp"
#include "core/grid/distance_grid.hpp"
#include "sim/studies/scene/damped_inertia.hpp"

namespace feltwire {
namespace {

constexpr double kNoLimit = 1000.0;      // [N] force limit that is too high to act
constexpr double kMass = 0.1;            // [kg] mass of a tool with mass
constexpr std::size_t kShownPoints = 8;  // number of points to display a tool of polygons

ToolInertia inertia_of(const TriangleSoup& surface, const ToolCoupling& coupling, bool midpoint) {
  const MassProperties solid = mass_properties(TriangleMesh(surface));
  ToolInertia inertia;
  inertia.mass = kMass;
  inertia.integration = midpoint ? ToolIntegration::midpoint : ToolIntegration::implicit;
  inertia.center = solid.center;
  inertia.inertia = kMass / solid.volume * solid.inertia;
  return critically_damped(inertia, coupling);
}

template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

std::size_t bytes_of(const PointShell& shell) {
  std::size_t bytes = sizeof(shell) + bytes_of(shell.points) + bytes_of(shell.nodes);
  for (const PointShell& side : shell.sides) bytes += bytes_of(side);
  return bytes;
}

std::size_t bytes_of(const Polyhedron& solid) {
  return sizeof(solid) + bytes_of(solid.vertices) + bytes_of(solid.planes) + bytes_of(solid.first) +
         bytes_of(solid.loop) + bytes_of(solid.edges) + bytes_of(solid.graph);
}

}  // namespace

SixDofTool sixdof_tool(const SixDofTask& task, SixDofMethod method, std::size_t points,
                       double grid_steps) {
  const auto polygons = method.polygons ? std::make_shared<const PolygonBody>(
                                              polygon_body(task.tool.parts, {solid_parts_of(task)}))
                                        : nullptr;
  // Use the radius of the surface for points and for polygons, so that both have the same coupling.
  // The radius of a point shell would differ: it is the distance of its farthest point.
  double radius = 0.0;
  for (const Vec3& v : task.tool.surface.vertices) radius = std::max(radius, v.norm());
  ToolCoupling coupling{.stiffness = kSixDofStiffness, .max_force = kNoLimit};
  coupling.rotational_stiffness = kSixDofStiffness * radius * radius;
  coupling.max_torque = kNoLimit * radius;
  Object solid;
  if (method.polygons) {
    solid.name = task.name;
    solid.pose = task.place;
    solid.material.stiffness = kSixDofStiffness;
  } else {
    solid = object_of(task, kSixDofStiffness, grid_steps);
  }
  return {BodyTool(point_shell(task.tool.surface, method.polygons ? kShownPoints : points),
                   coupling, task.contact_area,
                   method.mass ? inertia_of(task.tool.surface, coupling, method.midpoint)
                               : ToolInertia{},
                   polygons),
          solid, polygons};
}

SixDofTool stiffer(const SixDofTool& tool, double stiffness) {
  ToolCoupling coupling = tool.tool.coupling();
  coupling.rotational_stiffness *= stiffness / coupling.stiffness;
  coupling.stiffness = stiffness;
  ToolInertia inertia = tool.tool.inertia();
  inertia.damping = inertia.rotational_damping = 0.0;
  SixDofTool result{
      BodyTool(tool.tool.shell(), coupling, tool.tool.contact_area(), inertia, tool.polygons),
      tool.solid, tool.polygons};
  result.solid.material.stiffness = stiffness;
  return result;
}

std::size_t contact_bytes(const SixDofTool& tool) {
  if (!tool.polygons) {
    std::size_t bytes = bytes_of(tool.tool.shell());
    if (const auto* grid = std::get_if<Grid>(&tool.solid.shape)) bytes += grid->field->bytes();
    return bytes;
  }
  std::size_t bytes = sizeof(PartPairs);
  for (const Polyhedron& part : tool.polygons->parts) bytes += bytes_of(part);
  for (const SolidParts& solid : tool.polygons->solids)
    for (const SolidPart& part : solid.parts)
      bytes += bytes_of(part.shape) + bytes_of(part.inner) + bytes_of(part.beyond);
  return bytes;
}

}  // namespace feltwire
