#include "core/scene/scene_cost_report.hpp"

#include <algorithm>
#include <functional>

#include "core/base/written_number.hpp"
#include "core/grid/distance_grid.hpp"
#include "core/mesh/mesh_distance.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/validation.hpp"
#include "core/tool/body_tool.hpp"
#include "core/tool/polygon_body.hpp"

namespace feltwire {
namespace {

template <class Part>
std::vector<std::string> names(const std::vector<Part>& parts,
                               const std::function<bool(const Part&)>& chosen) {
  std::vector<std::string> names;
  for (const Part& part : parts)
    if (chosen(part)) names.push_back(part.name);
  return names;
}

/// The mesh options of an object; null if it is no mesh.
const MeshOptions* mesh_of(const Object& object) {
  const auto* mesh = std::get_if<Mesh>(&object.shape);
  return mesh != nullptr ? &mesh->surface->options() : nullptr;
}

/// Moving objects stand behind the others.
bool moves(const ToolView& view, const Object& object) {
  return static_cast<std::size_t>(&object - view.objects().data()) >= view.still();
}

/// A tool that all hands hold has no name of its own.
std::string tool_name(const HandTool& tool) { return tool.name.empty() ? "tool" : tool.name; }

std::vector<std::string> tools_if(const Scene& scene,
                                  const std::function<bool(const HandTool&)>& chosen) {
  std::vector<std::string> names;
  for (const ToolView& view : scene.views())
    if (chosen(view.tool())) names.push_back(tool_name(view.tool()));
  return names;
}

/// The objects that are chosen with at least one tool.
std::vector<std::string> objects_if(
    const Scene& scene, const std::function<bool(const ToolView&, const Object&)>& chosen) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < scene.objects().size(); ++i)
    if (std::ranges::any_of(scene.views(),
                            [&](const ToolView& view) { return chosen(view, view.objects()[i]); }))
      names.push_back(scene.objects()[i].name);
  return names;
}

/// The time of a step grows with the faces that touch.
std::string polygons_text(const PolygonBody& polygons) {
  std::size_t faces = 0;
  for (const Polyhedron& part : polygons.parts) faces += part.planes.size();
  return "polygons in " + std::to_string(polygons.parts.size()) + " convex parts with " +
         std::to_string(faces) + " faces";
}

/// The cost of the bodies in the hand: points or polygons that touch, orientation and torque.
std::string body_cost(const Scene& scene) {
  std::string text;
  for (const ToolView& view : scene.views()) {
    const auto& body = view.tool().body;
    if (body && body->polygons() != nullptr)
      text += (text.empty() ? "" : "; ") + polygons_text(*body->polygons());
    else if (body && text.find("points") == std::string::npos)
      text += text.empty() ? "points" : "; points";
  }
  return (text.empty() ? "points" : text) + ", orientation and torque";
}

std::string tool_kind(const HandTool& tool) {
  if (tool.body) {
    const PolygonBody* polygons = tool.body->polygons();
    const double mass = tool.body->inertia().mass;
    return (polygons != nullptr
                ? polygons_text(*polygons)
                : "a body of " + std::to_string(tool.body->shell().points.size()) + " points") +
           (mass > 0.0 ? ", " + number_text(mass) + " kg" : "");
  }
  return tool.radius > 0.0 ? "a ball of " + number_text(tool.radius) + " m" : "a point";
}

/// The names of the tools.
std::string listed_tools(const Scene& scene) {
  std::string text;
  for (const ToolView& view : scene.views())
    text += (text.empty() ? "  tools: " : ", ") + view.tool().name + " (" + tool_kind(view.tool()) +
            (&view == scene.view("") ? "; of hands that ask for none)" : ")");
  return text + "\n";
}

/// The grids that bodies touch. All bodies share them.
std::vector<ToolView::Sampled> grids_for_bodies(const Scene& scene) {
  for (const ToolView& view : scene.views())
    if (!view.sampled().empty()) return view.sampled();
  return {};
}

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::string length_text(double metres) { return printed("%.4g", metres); }

/// [m] Half the sides of the box about an object, in its own frame; empty if it is endless.
std::optional<Vec3> half_box_of(const Shape& shape) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return mesh->surface->mesh().half_extents();
  if (const auto* grid = std::get_if<Grid>(&shape))
    return Vec3(0.5 * (grid->field->high() - grid->field->low()));
  return on_primitive(
      shape,
      [](const auto& solid) -> std::optional<Vec3> {
        if (!is_bounded(solid)) return std::nullopt;
        return solid.half_box();
      },
      [] { return std::optional<Vec3>(); });
}

/// A line for each object, which shows a wrong unit at once.
std::string sizes_text(const Scene& scene) {
  constexpr std::size_t kShown = 32;
  std::string text;
  const std::vector<Object>& objects = scene.objects();
  for (std::size_t i = 0; i < objects.size() && i < kShown; ++i) {
    text += "  size of " + objects[i].name + ": ";
    const auto half = half_box_of(objects[i].shape);
    if (half)
      text += length_text(2.0 * half->x()) + " x " + length_text(2.0 * half->y()) + " x " +
              length_text(2.0 * half->z()) + " m\n";
    else
      text += "endless\n";
  }
  if (objects.size() > kShown)
    text += "  and " + std::to_string(objects.size() - kShown) + " objects more\n";
  return text;
}

/// The first few names, and the number of the rest.
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 5;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kShown; ++i)
    text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kShown) text += " and " + std::to_string(names.size() - kShown) + " more";
  return text;
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

std::vector<FeatureCost> feature_costs(const Scene& scene) {
  const auto objects = [&](const std::function<bool(const Object&)>& chosen) {
    return objects_if(scene, [&](const ToolView&, const Object& o) { return chosen(o); });
  };
  const auto guides = [&](const std::function<bool(const Guide&)>& chosen) {
    return names<Guide>(scene.guides(), chosen);
  };
  return {
      {"contact",
       "a query an object and sample, " + std::to_string(sizeof(ContactMemory)) +
           " bytes an object and tool",
       objects([](const Object&) { return true; })},
      {"stick points", "a spring along the surface while it is touched",
       objects([](const Object& o) { return o.material.static_friction > 0.0; })},
      {"velocity", "an estimate a tool",
       objects([](const Object& o) {
         return o.material.damping > 0.0 || o.material.viscous_friction > 0.0;
       }) + guides([](const Guide& g) { return needs_velocity(g); })},
      {"guides", "a query a guide and sample", guides([](const Guide&) { return true; })},
      {"triangles", "a walk over the surface, a tree",
       objects([](const Object& o) { return mesh_of(o) != nullptr; })},
      {"triangles about a ball", "distances to all that are near",
       objects_if(scene,
                  [](const ToolView& view, const Object& o) {
                    return mesh_of(o) != nullptr && mesh_of(o)->radius + view.tool().radius > 0.0;
                  })},
      {"smooth normals", "a normal a corner",
       objects([](const Object& o) { return mesh_of(o) != nullptr && mesh_of(o)->smooth; })},
      {"grain", "waves where it is touched", objects([](const Object& o) {
         return mesh_of(o) != nullptr && mesh_of(o)->grain.amplitude > 0.0;
       })},
      {"distance grids", "bricks of distances about a surface",
       objects([](const Object& o) { return std::holds_alternative<Grid>(o.shape); })},
      {"a ball in the hand", "edges and corners rounded",
       tools_if(scene, [](const HandTool& tool) { return tool.radius > 0.0; })},
      {"a body in the hand", body_cost(scene),
       tools_if(scene, [](const HandTool& tool) { return tool.body != nullptr; })},
      {"motion", "a tick of MuJoCo's, places and forces of what moves", objects_if(scene, moves)},
      {"a tree over the objects", "boxes along the hand's way",
       objects_if(scene, [](const ToolView& view,
                            const Object& o) { return view.by_tree() && !moves(view, o); })},
  };
}

std::optional<StartInside> start_inside(const Scene& scene) {
  constexpr double kLeast = 1e-4;  // [m] hardly felt; a start may lie on a surface
  std::optional<StartInside> deepest;
  for (const Object& object : scene.objects()) {
    FeatureMemory memory;
    const double depth =
        surface_point(object, scene.start().position, scene.tool().radius, memory).depth;
    // Accept a ball whose middle starts on the surface: this is meant.
    if (depth > kLeast + scene.tool().radius && (!deepest || depth > deepest->depth))
      deepest = {object.name, depth - scene.tool().radius};
  }
  return deepest;
}

std::string describe_costs(const Scene& scene) {
  std::string text =
      "scene " + scene.name() + ": " + counted(scene.objects().size(), "object", "objects") + ", " +
      counted(scene.guides().size(), "guide", "guides") + ", " +
      std::to_string(scene.objects().size() * sizeof(ContactMemory)) + " bytes a tool\n";
  if (!scene.tool().name.empty()) text += listed_tools(scene);
  text += sizes_text(scene);
  if (const auto inside = start_inside(scene))
    text +=
        "  the start (" + length_text(scene.start().position.x()) + ", " +
        length_text(scene.start().position.y()) + ", " + length_text(scene.start().position.z()) +
        ") m lies inside " + inside->object + ", " + length_text(inside->depth) +
        " m deep: a hand that begins there is pushed at once; put start.position on a surface\n";
  std::string unused;
  for (const FeatureCost& need : feature_costs(scene)) {
    if (need.needed.empty())
      unused += (unused.empty() ? "" : ", ") + need.what;
    else
      text += "  " + need.what + " (" + need.cost + "): " + listed(need.needed) + "\n";
  }
  for (const ToolView::Sampled& mesh : grids_for_bodies(scene))
    text += "  grid of distances for the tool's body: mesh " + mesh.object + ", a sample every " +
            number_text(mesh.resolution) + " m (its longest side over " +
            number_text(kMeshGridSteps) + "); give it as a grid to choose\n";
  for (const std::string& note : scene.notes()) text += "  " + note + "\n";
  if (!unused.empty()) text += "  nothing is spent on: " + unused + "\n";
  const double k = scene.requirements().stiffness;
  if (k > 0.0)
    text += "  stiffest: " + number_text(k) + " N/m. A device of " + number_text(0.5e-3 * k) +
            " N s/m and more renders all of it at 1 kHz by its damping alone (b >= k T / 2). With "
            "less, the usual mode shaped returns what the device has dissipated\n";
  return text;
}

}  // namespace feltwire
