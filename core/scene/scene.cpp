#include "core/scene/scene.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene/validation.hpp"

namespace feltwire {

Scene::Scene(std::string name, std::vector<Object> objects, const Start& start,
             std::vector<Guide> guides)
    : name_(std::move(name)), start_(start) {
  if (auto violation = broken_name(name_)) refuse("scene", *violation);
  if (auto violation = check(start_)) refuse("start", *violation);
  start_.normal = direction(start_.normal);
  if (objects.empty() && guides.empty())
    refuse("scene", {"objects", "there is none to touch, and no guide; add at least one"});
  std::set<std::string> names;
  for (Object& object : objects) {
    const std::string whose = "object '" + object.name + "'";
    if (auto violation = broken_name(object.name)) refuse(whose, *violation);
    if (!names.insert(object.name).second)
      refuse(whose, {"name", "stands twice in the scene; rename one"});
    if (auto violation = check(object.shape)) refuse(whose, *violation);
    if (auto violation = check(object.material)) refuse(whose, *violation);
    if (auto violation = check(object.pose)) refuse(whose, *violation);
    make_unit(object.pose.orientation);
  }
  names.clear();
  for (Guide& guide : guides) {
    const std::string whose = "guide '" + guide.name + "'";
    if (auto violation = broken_name(guide.name)) refuse(whose, *violation);
    if (!names.insert(guide.name).second)
      refuse(whose, {"name", "stands twice in the scene; rename one"});
    if (auto violation = check(guide)) refuse(whose, *violation);
    make_unit(guide.pose.orientation);
  }
  views_.push_back(ToolView(std::make_shared<const std::vector<Object>>(std::move(objects)),
                            std::make_shared<const std::vector<Guide>>(std::move(guides))));
}

void Scene::set_tool(HandTool tool) { views_ = {views_.front().with(std::move(tool))}; }

void Scene::set_tools(std::vector<HandTool> tools) {
  if (auto violation = broken_tools(tools.size())) refuse("scene", *violation);
  std::set<std::string> names;
  for (const HandTool& tool : tools) {
    if (auto violation = broken_name(tool.name)) refuse(description_of(tool), *violation);
    if (!names.insert(tool.name).second)
      refuse(description_of(tool), {"name", "stands twice in the scene; rename one"});
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

void Scene::set_material(std::size_t object, const Material& material) {
  if (auto violation = check(material))
    refuse("object '" + objects()[object].name + "'", *violation);
  // Views that share a list of objects share the new one.
  std::vector<std::pair<ToolView::Objects, ToolView::Objects>> lists;  // old, new
  std::vector<ToolView> views;
  views.reserve(views_.size());
  for (const ToolView& view : views_) {
    auto list = std::ranges::find(lists, view.objects_, &decltype(lists)::value_type::first);
    if (list == lists.end()) {
      const auto changed = std::make_shared<std::vector<Object>>(*view.objects_);
      (*changed)[object].material = material;
      list = lists.emplace(lists.end(), view.objects_, changed);
    }
    views.push_back(view.with(list->second));
  }
  views_ = std::move(views);
}

void Scene::set_mechanism(std::shared_ptr<const Mechanism> mechanism) {
  const std::size_t count = objects().size();
  if (mechanism != nullptr && mechanism->still() + mechanism->parts().size() != count)
    refuse("scene",
           {"mechanism",
            "was compiled for " + std::to_string(mechanism->still() + mechanism->parts().size()) +
                " objects, here are " + std::to_string(count) + "; compile it for these"});
  mechanism_ = std::move(mechanism);
  if (mechanism_ != nullptr)
    warnings_.insert(warnings_.end(), mechanism_->warnings().begin(), mechanism_->warnings().end());
  for (ToolView& view : views_) view.set_still(mechanism_ != nullptr ? mechanism_->still() : count);
}

}  // namespace feltwire
