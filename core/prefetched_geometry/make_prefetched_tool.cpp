#include "core/prefetched_geometry/make_prefetched_tool.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/mesh/mesh_distance.hpp"
#include "core/point_shell/shell_surroundings.hpp"
#include "core/prefetched_geometry/trial_ways.hpp"
#include "core/tool_coupling/tool_checks.hpp"

namespace feltwire {
namespace {

/// The surroundings of a tool. They own the tool's shell and their objects.
class OwnSurroundings final : public ToolSurroundings {
 public:
  OwnSurroundings(PointShell shell, double contact_area, std::vector<Object> objects)
      : shell_(std::move(shell)),
        objects_(std::move(objects)),
        surroundings_(shell_, contact_area, objects_) {}
  OwnSurroundings(const OwnSurroundings&) = delete;
  OwnSurroundings& operator=(const OwnSurroundings&) = delete;

  ShellContact contact(const Pose& tool, WorkLimit* work) const noexcept override {
    return surroundings_.contact(tool, work);
  }

 private:
  PointShell shell_;
  std::vector<Object> objects_;
  ShellSurroundings surroundings_;
};

/// Returns false for a negative number, infinity or NaN.
bool not_below_zero(double x) { return x >= 0.0 && std::isfinite(x); }

bool possible(const Material& m) {
  return m.stiffness > 0.0 && std::isfinite(m.stiffness) && not_below_zero(m.damping) &&
         not_below_zero(m.viscous_friction) && not_below_zero(m.dynamic_friction) &&
         not_below_zero(m.static_friction) && m.dynamic_friction <= m.static_friction;
}

bool possible(const Shape& shape) {
  bool good = true;
  const auto look = [&](const auto& primitive) {
    primitive.lengths(primitive, [&](const Length& length, double value) {
      good = good && not_below_zero(value) && (value > 0.0 || length.may_be_zero) &&
             value <= length.share * length.most;
    });
    return good;
  };
  return on_primitive(shape, look, [] { return false; });
}

/// The shape that is felt; empty if it is a grid of more bytes than `grid_room`. A grid takes its
/// bytes off the room.
std::optional<Shape> shape_of(const SolidData& solid, std::size_t& grid_room) {
  if (solid.mesh.triangles.empty()) return solid.shape;
  try {
    Grid grid = grid_for_body(std::make_shared<const MeshSurface>(TriangleMesh(solid.mesh, 0.0)),
                              grid_room);
    grid_room -= std::min(grid_room, grid.field->bytes());
    return grid;
  } catch (const GridTooLarge&) {
    return std::nullopt;
  }
}

void check(const SolidData& solid) {
  const bool is_mesh = !solid.mesh.triangles.empty();
  if (!possible(solid.material) || !(is_mesh || possible(solid.shape)) ||
      !solid.pose.position.allFinite())
    throw std::invalid_argument("object " + std::to_string(solid.object) +
                                ": its numbers are not those of a solid");
}

void check(const BodyData& tool) {
  check(tool.coupling);
  check(tool.inertia);
  require_above_zero("contact_area", tool.contact_area, "[m^2]");
  require_above_zero("area", tool.area, "[m^2]");
  const auto finite = [](const Vec3& p) { return p.allFinite(); };
  if (tool.points.empty() || tool.points.size() > kMaxShellPoints ||
      !std::ranges::all_of(tool.points, finite))
    throw std::invalid_argument("points: are not those of a body");
}

}  // namespace

std::shared_ptr<const PrefetchedTool> make_prefetched_tool(std::uint32_t version,
                                                           const BodyData& tool,
                                                           const std::vector<SolidData>& solids,
                                                           std::size_t grid_room) {
  check(tool);
  std::vector<SolidData> felt;
  std::vector<std::uint16_t> numbers;
  std::vector<Object> objects;
  for (const SolidData& solid : solids) {
    check(solid);
    std::optional<Shape> shape = shape_of(solid, grid_room);
    if (!shape) continue;
    felt.push_back(solid);
    numbers.push_back(solid.object);
    objects.push_back({.name = {},
                       .shape = *std::move(shape),
                       .felt_from = solid.from_inside ? Side::inside : Side::outside,
                       .pose = solid.pose,
                       .material = solid.material});
  }
  PointShell shell = point_shell(tool.points, tool.area);
  const double radius = shell.radius;
  require_above_zero("radius", radius, "[m]");
  return std::make_shared<const PrefetchedTool>(
      PrefetchedTool{.version = version,
                     .objects = std::move(numbers),
                     .coupling = tool.coupling,
                     .radius = radius,
                     .inertia = tool.inertia,
                     .solids = std::make_unique<const OwnSurroundings>(
                         std::move(shell), tool.contact_area, std::move(objects)),
                     .ways = body_ways(felt, radius)});
}

}  // namespace feltwire
