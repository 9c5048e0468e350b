// The tools of a scene: one for all hands, or several to choose from.

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/contact/ball.hpp"
#include "core/mesh/mesh_distance.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/validation.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

/// A body touches distances; a mesh that was not given as a grid becomes one.
Scene::Sampled sample_for_body(Object& object, const Mesh& mesh) {
  const TriangleMesh& triangles = mesh.surface->mesh();
  GridOptions options;
  options.resolution = 2.0 * triangles.half_extents().maxCoeff() / Scene::kMeshGridSteps;
  try {
    object.shape = Grid{std::make_shared<const DistanceGrid<float>>(solid_of(triangles), options)};
  } catch (const std::invalid_argument& error) {
    refuse("object '" + object.name + "'",
           {"mesh", std::string("is touched by a body, as a grid of distances: ") + error.what()});
  }
  return {object.name, options.resolution};
}

std::string whose(const HandTool& tool) {
  return tool.name.empty() ? "tool" : "tool '" + tool.name + "'";
}

}  // namespace

MaybeViolation check(const HandTool& tool, std::span<const Object> objects) {
  if (tool.radius == 0.0) return std::nullopt;
  if (tool.body) return Violation{"sphere", "is a second tool beside body; keep one of the two"};
  if (auto violation = positive("sphere.radius", tool.radius, kMaxLength, " [m]")) return violation;
  for (const Object& object : objects)
    if (!ball_fits(object.shape, object.felt_from, tool.radius))
      return Violation{"sphere.radius",
                       "is " + number_text(tool.radius) + " m, too large for object '" +
                           object.name +
                           "': a hollow has no room for it, or a grid's band is smaller; make the "
                           "tool smaller or these larger"};
  return std::nullopt;
}

MaybeViolation broken_tools(std::size_t count) {
  if (count >= 1 && count <= kMaxTools) return std::nullopt;
  return Violation{"tools", "must be 1 to " + std::to_string(kMaxTools) + ", are " +
                                std::to_string(count) + "; " +
                                (count == 0 ? "name one, or leave them out" : "name fewer")};
}

void Scene::find_by_tree() {
  broad_phase_ = tool_.body ? BroadPhase{}  // it touches by itself
                            : BroadPhase({objects_.data(), still_}, tool_.radius);
}

void Scene::set_tool(HandTool tool) {
  if (auto violation = check(tool, objects_)) refuse(whose(tool), *violation);
  if (tool.body) {
    std::vector<Object> objects = objects_;
    std::vector<Sampled> sampled = sampled_;
    for (Object& object : objects)
      if (const auto* mesh = std::get_if<Mesh>(&object.shape))
        sampled.push_back(sample_for_body(object, Mesh(*mesh)));
    objects_ = std::move(objects);
    sampled_ = std::move(sampled);
  }
  requirements_.rotation = tool.body != nullptr;
  tool_ = std::move(tool);
  others_.clear();
  find_by_tree();
}

void Scene::set_tools(std::vector<HandTool> tools) {
  if (auto violation = broken_tools(tools.size())) refuse("scene", *violation);
  std::set<std::string> names;
  for (const HandTool& tool : tools) {
    if (auto violation = broken_name(tool.name)) refuse(whose(tool), *violation);
    if (!names.insert(tool.name).second)
      refuse(whose(tool), {"name", "stands twice in the scene; rename one"});
  }
  // Bodies share the grids that one of them needed first.
  std::vector<std::shared_ptr<Scene>> scenes;
  const Scene* sampled = nullptr;
  for (HandTool& tool : tools) {
    const bool body = tool.body != nullptr;
    scenes.push_back(std::make_shared<Scene>(body && sampled != nullptr ? *sampled : *this));
    scenes.back()->set_tool(std::move(tool));
    if (body) sampled = scenes.back().get();
  }
  *this = std::move(*scenes.front());
  others_.assign(scenes.begin() + 1, scenes.end());
}

const Scene* Scene::held(std::string_view tool) const noexcept {
  if (tool.empty() || tool == tool_.name) return this;
  const auto found = std::ranges::find(
      others_, tool, [](const auto& other) { return std::string_view(other->tool_.name); });
  return found != others_.end() ? found->get() : nullptr;
}

}  // namespace feltwire
