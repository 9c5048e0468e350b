#include "core/scene/tool_view.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/mesh/mesh_distance.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/validation.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

Requirements required_by(const std::vector<Object>& objects, const std::vector<Guide>& guides) {
  Requirements r;
  for (const Object& o : objects) {
    r.friction |= o.material.static_friction > 0.0;
    r.velocity |= o.material.damping > 0.0 || o.material.viscous_friction > 0.0;
    r.stiffness = std::max(r.stiffness, o.material.stiffness);
  }
  r.guides = !guides.empty();
  for (const Guide& guide : guides) {
    r.velocity |= needs_velocity(guide);
    r.stiffness = std::max(r.stiffness, stiffness(guide));
  }
  return r;
}

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

}  // namespace

ToolView::ToolView(Objects objects, Guides guides)
    : objects_(std::move(objects)),
      guides_(std::move(guides)),
      requirements_(required_by(*objects_, *guides_)) {
  set_still(objects_->size());
}

void ToolView::set_still(std::size_t count) {
  still_ = count;
  broad_phase_ = tool_.body ? BroadPhase{}  // a body finds its own contacts
                            : BroadPhase({objects_->data(), still_}, tool_.radius);
}

ToolView ToolView::with(HandTool tool) const {
  if (auto violation = check(tool, *objects_)) refuse(description_of(tool), *violation);
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

ToolView ToolView::with(Objects objects) const {
  ToolView view = *this;
  view.objects_ = std::move(objects);
  view.requirements_ = required_by(*view.objects_, *guides_);
  view.requirements_.rotation = requirements_.rotation;
  return view;
}

TouchMemory ToolView::memory() const {
  TouchMemory memory(objects_->size());
  if (!broad_phase_.in_use()) return memory;
  memory.live_.reserve(objects_->size());
  memory.asked_.reserve(2 * objects_->size());
  return memory;
}

/// Touches the objects that the tool's way meets or that hold it. It sums in the order of the
/// objects, so that the bits of the sum do not depend on the tree.
Command ToolView::touch_near(const Tool& tool, TouchMemory& memory) const noexcept {
  const Vec3 from = memory.tracked_ ? memory.position_ : tool.position;
  std::vector<std::uint32_t>& asked = memory.asked_;
  asked.assign(memory.live_.begin(), memory.live_.end());
  const auto ask = [&](std::uint32_t i) {
    if (asked.size() == asked.capacity()) [[unlikely]]
      return;  // cannot happen: each object comes at most twice
    asked.push_back(i);
  };
  for (const std::uint32_t i : broad_phase_.everywhere()) ask(i);
  const auto known = static_cast<std::ptrdiff_t>(memory.live_.size());
  broad_phase_.along(from, tool.position, ask);
  // If an object's memory is older than the last sample, give it the tool's last place.
  const auto is_live = [&](std::uint32_t i) {
    return std::find(asked.begin(), asked.begin() + known, i) != asked.begin() + known;
  };
  for (std::size_t n = static_cast<std::size_t>(known); n < asked.size(); ++n) {
    const Object& object = (*objects_)[asked[n]];
    if (!memory.tracked_ || is_live(asked[n]) || !follows_way(object.shape, object.felt_from))
      continue;
    approach_from(object.shape, object.pose.orientation.conjugate() * (from - object.pose.position),
                  memory[asked[n]].feature);
  }
  std::sort(asked.begin(), asked.end());
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());

  Command sum;
  memory.live_.clear();
  for (const std::uint32_t i : asked) {
    add_touch((*objects_)[i], tool, memory[i], tool_.radius, sum);
    if (memory[i].touching || memory[i].feature.side != 0)
      memory.live_.push_back(i);
    else
      memory[i] = {};
  }
  memory.tracked_ = true;
  memory.position_ = tool.position;
  return sum;
}

void ToolView::add_guides(const Tool& tool, Command& sum) const noexcept {
  Command guides;
  for (const Guide& guide : *guides_) {
    const Command part = guide_force(guide, tool);
    guides.elastic += part.elastic;
    guides.frictional += part.frictional;
  }
  if (objects_->empty()) {
    sum.elastic += guides.elastic;
    sum.frictional += guides.frictional;
    return;
  }
  const Vec3 all = guides.force();
  if (all.isZero(0.0)) return;
  sum.frictional += all;
  // If guides pull harder into a surface than it pushes, the contact would pull. No bound would let
  // that through.
  if (sum.force().dot(sum.elastic) > 0.0) return;
  sum.frictional += sum.elastic;
  sum.elastic.setZero();
}

Command ToolView::touch(const Pose& device, const Vec3& velocity, double elapsed,
                        BodyMemory& memory) const noexcept {
  Command command = step_body(*tool_.body, *objects_, device, elapsed, memory).command;
  add_guides({device.position, velocity}, command);
  return command.finite() ? command : Command{};
}

Command ToolView::touch(const Tool& tool, TouchMemory& memory, std::size_t count) const noexcept {
  if (!tool.position.allFinite() || !tool.velocity.allFinite() || memory.size() != objects_->size())
      [[unlikely]]
    return {};
  Command sum;
  const bool by_tree = broad_phase_.in_use();
  if (by_tree) sum = touch_near(tool, memory);
  for (std::size_t i = by_tree ? still_ : 0; i < count; ++i)
    add_touch((*objects_)[i], tool, memory[i], tool_.radius, sum);
  return sum;
}

}  // namespace feltwire
