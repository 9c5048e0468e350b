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

/// A body needs distances. So a mesh that was not given as a grid becomes a grid.
ToolView::Sampled sample_for_body(Object& object, std::size_t index) {
  const auto surface = std::get<Mesh>(object.shape).surface;
  try {
    object.shape = grid_for_body(surface);
  } catch (const std::invalid_argument& error) {
    refuse("object '" + object.name + "'",
           {"mesh", std::string("is touched by a body, as a grid of distances: ") + error.what()});
  }
  return {object.name, grid_resolution(surface->mesh()), index, surface};
}

std::string whose(const HandTool& tool) {
  return tool.name.empty() ? "tool" : "tool '" + tool.name + "'";
}

}  // namespace

MaybeViolation check(const HandTool& tool, std::span<const Object> objects) {
  if (tool.body && tool.body->polygons() != nullptr &&
      tool.body->polygons()->solids.size() != objects.size())
    return Violation{"body.contact", "is polygons, with " +
                                         std::to_string(tool.body->polygons()->solids.size()) +
                                         " solids for " + std::to_string(objects.size()) +
                                         " objects; make it for this scene"};
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

ToolView ToolView::with(HandTool tool) const {
  if (auto violation = check(tool, *objects_)) refuse(whose(tool), *violation);
  ToolView view = *this;
  const auto is_mesh = [](const Object& object) {
    return std::holds_alternative<Mesh>(object.shape);
  };
  if (tool.body && std::ranges::any_of(*objects_, is_mesh)) {
    const auto objects = std::make_shared<std::vector<Object>>(*objects_);
    for (std::size_t i = 0; i < objects->size(); ++i)
      if (is_mesh((*objects)[i])) view.sampled_.push_back(sample_for_body((*objects)[i], i));
    view.objects_ = objects;
  }
  view.requirements_.rotation = tool.body != nullptr;
  view.tool_ = std::move(tool);
  view.set_still(still_);
  return view;
}

void Scene::set_tool(HandTool tool) { views_ = {views_.front().with(std::move(tool))}; }

void Scene::set_tools(std::vector<HandTool> tools) {
  if (auto violation = broken_tools(tools.size())) refuse("scene", *violation);
  std::set<std::string> names;
  for (const HandTool& tool : tools) {
    if (auto violation = broken_name(tool.name)) refuse(whose(tool), *violation);
    if (!names.insert(tool.name).second)
      refuse(whose(tool), {"name", "stands twice in the scene; rename one"});
  }
  // Bodies share the grids that the first of them needed.
  std::vector<ToolView> views;
  views.reserve(tools.size());
  const ToolView* sampled = nullptr;
  for (HandTool& tool : tools) {
    const bool body = tool.body != nullptr;
    views.push_back((body && sampled != nullptr ? *sampled : views_.front()).with(std::move(tool)));
    if (body) sampled = &views.back();
  }
  views_ = std::move(views);
}

const ToolView* Scene::view(std::string_view tool) const noexcept {
  if (tool.empty()) return &views_.front();
  const auto found =
      std::ranges::find_if(views_, [&](const ToolView& view) { return view.tool().name == tool; });
  return found != views_.end() ? &*found : nullptr;
}

std::string Scene::tool_names() const {
  std::string names;
  for (const ToolView& view : views_) names += (names.empty() ? "" : ", ") + view.tool().name;
  return names;
}

}  // namespace feltwire
