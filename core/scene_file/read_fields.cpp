#include "core/scene_file/read_fields.hpp"

#include <optional>
#include <utility>

#include "core/grid/signed_distance.hpp"
#include "core/mesh/box_tree.hpp"
#include "core/mesh/mesh_distance.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/scene_file/load_mesh.hpp"
#include "core/scene_file/read_polygons.hpp"
#include "core/scene_file/read_tool_mass.hpp"
#include "core/scene_file/read_values.hpp"
#include "core/scene_file/shown_error.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

std::string solids() { return names_of_primitives(true) + ", file"; }

constexpr int kSegments = 128;  // number of segments around a round body

/// A shape, or a surface from a file.
struct ShapeOrSurface {
  std::optional<Shape> shape;
  TriangleSoup surface;
  std::optional<std::string> warning = {};  // warning about the file of the surface
};

double size_of(const TriangleSoup& surface) {
  Bounds box;
  for (const Triangle& t : surface.triangles)
    for (const std::uint32_t i : t) box.add(surface.vertices[i]);
  return (box.most - box.least).maxCoeff();
}

/// Reads the solid of a table. Reports an error if the table has more than one.
template <class Table>
ShapeOrSurface read_solid(const JsonDocument& document, const std::string& path, const Table& table,
                          const std::filesystem::path& folder) {
  ShapeOrSurface given;
  std::string kind;
  const auto take = [&](const char* name) {
    if (!kind.empty())
      document.fail(path + "." + name,
                    "is a second solid beside " + kind + "; keep exactly one of " + solids());
    kind = name;
  };
  const auto take_shape = [&](const char* name, const Shape& shape) {
    take(name);
    require(document, path + "." + name, check(shape));
    given.shape = shape;
  };
  take_primitives(document, path, take_shape);
  if (const auto* file = table.file()) {
    take("file");
    if (!(table.scale() > 0.0))
      document.fail(path + ".scale", "must be above zero [m per unit of the file], is " +
                                         number_text(table.scale()) +
                                         "; give 0.001 for a file in millimetres");
    if (!(table.scale() <= kMaxLength))
      document.fail(path + ".scale", "must be at most " + number_text(kMaxLength) +
                                         " [m per unit of the file], is " +
                                         number_text(table.scale()) + "; check the unit");
    given.surface = read_scene_mesh(folder, file->str(), table.scale());
    given.warning = odd_size(file->str(), size_of(given.surface), table.scale());
  }
  if (kind.empty()) document.fail(path, "has no solid; give exactly one of " + solids());
  return given;
}

Solid solid(const ShapeOrSurface& given) {
  return given.shape ? solid_of(*given.shape) : solid_of(TriangleMesh(given.surface, {}, true));
}

TriangleSoup placed(TriangleSoup surface, const Pose& pose) {
  for (Vec3& v : surface.vertices) v = pose.position + pose.orientation * v;
  return surface;
}

Pose read_place(const JsonDocument& document, const std::string& path,
                const scene_file::ToolBody& body) {
  Pose pose = pose_of(body);
  require(document, path, check(pose));
  make_unit(pose.orientation);
  return pose;
}

std::shared_ptr<const BodyTool> read_body(const JsonDocument& document, const std::string& path,
                                          const scene_file::ToolBody& body,
                                          const std::filesystem::path& folder,
                                          const scene_file::Scene& file, const Scene& scene,
                                          std::vector<std::string>& warnings) {
  const ShapeOrSurface given = read_solid(document, path, body, folder);
  if (given.warning) warnings.push_back(*given.warning);
  const Pose place = read_place(document, path, body);
  const ToolInertia inertia =
      read_tool_mass(document, path, body, file, given.shape, given.surface, place);
  ToolCoupling coupling;
  if (const auto* c = body.coupling())
    coupling = {c->stiffness(), c->rotational_stiffness(), c->max_force(), c->max_torque()};
  try {
    const TriangleSoup surface = given.shape ? tessellate(*given.shape, kSegments) : given.surface;
    return std::make_shared<const BodyTool>(
        point_shell(placed(surface, place), body.points()), coupling, body.contact_area(), inertia,
        read_polygons(document, path, body, surface, place, folder, file, scene));
  } catch (const std::invalid_argument& error) {
    document.fail(path, error.what());
  }
}

/// Reads a tool and checks that it fits the scene.
template <class Table>
HandTool read_tool(const JsonDocument& document, const std::string& path, const Table& tool,
                   const std::filesystem::path& folder, const scene_file::Scene& file,
                   const Scene& scene, std::vector<std::string>& warnings) {
  HandTool hand;
  if (const auto* sphere = tool.sphere()) {
    require(document, path + ".sphere", check(Shape(Sphere{sphere->radius()})));
    hand.radius = sphere->radius();
  }
  if (const auto* body = tool.body())
    hand.body = read_body(document, path + ".body", *body, folder, file, scene, warnings);
  require(document, path, check(hand, scene.objects()));
  return hand;
}

}  // namespace

Grid read_grid(const JsonDocument& document, const std::string& path, const scene_file::Grid& grid,
               const std::filesystem::path& folder, std::vector<std::string>& warnings) {
  const ShapeOrSurface given = read_solid(document, path, grid, folder);
  if (given.warning) warnings.push_back(*given.warning);
  try {
    return {std::make_shared<const DistanceGrid<float>>(
        solid(given), GridOptions{.resolution = grid.resolution(), .band = grid.band()})};
  } catch (const std::invalid_argument& error) {
    document.fail(path, error.what());
  }
}

void read_tools(const JsonDocument& document, const scene_file::Scene& file,
                const std::filesystem::path& folder, Scene& scene) {
  if (file.tool() && file.tools()) document.fail("tools", "stand beside tool; keep one of the two");
  std::vector<std::string> warnings = scene.warnings();
  try {
    if (const auto* tool = file.tool()) {
      if (!tool->sphere() && !tool->body())
        document.fail("tool", "holds nothing; give exactly one of sphere, body, or leave it out");
      scene.set_tool(read_tool(document, "tool", *tool, folder, file, scene, warnings));
    }
    if (const auto* named = file.tools()) {
      require(document, "", broken_tools(named->size()));
      std::vector<HandTool> tools;
      Names names(document, "tools");
      for (const scene_file::NamedTool* tool : *named) {
        names.add(tool->name()->str());
        HandTool hand = read_tool(document, element("tools", tools.size()), *tool, folder, file,
                                  scene, warnings);
        hand.name = tool->name()->str();
        tools.push_back(std::move(hand));
      }
      scene.set_tools(std::move(tools));
    }
  } catch (const std::invalid_argument& error) {  // For example, a mesh has no distance grid.
    document.fail(file.tool() ? "tool" : "tools", error.what());
  }
  scene.warn(std::move(warnings));
}

}  // namespace feltwire
