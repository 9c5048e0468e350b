// A point or a ball in a world: which moving objects it asks, and how they answer.

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/dynamics/world.hpp"
#include "core/geometry/segment.hpp"

namespace feltwire {
namespace {

Vec3 seen_from(const Pose& pose, const Vec3& position) {
  return pose.orientation.conjugate() * (position - pose.position);
}

}  // namespace

void World::forget_moving(BodyContactState& contacts, TouchMemory& memory) const noexcept {
  for (std::size_t i = still_; i < memory.size(); ++i) memory[i] = {};
  std::ranges::fill(contacts.forces, Vec3::Zero());
  std::ranges::fill(contacts.nearness, NeighbourState::far);
  contacts.near.forget();
  contacts.resets = counters_.resets;
}

/// Whether the tool is near an object that follows its way, or has passed it since the last query
/// at contacts.tool. The way is the one relative to the object. For an object that was in no list,
/// the way begins where the object's pose of one step ago saw the tool; older poses are unknown.
bool World::comes_near(const MovedView& held, std::size_t part, const Vec3& position,
                       const BodyContactState& contacts, FeatureMemory& memory) const noexcept {
  const bool is_near = held.reach.is_near(part, position), known = contacts.near.known();
  const NeighbourState before = contacts.nearness[part];
  if (before == NeighbourState::asked || !known) return before == NeighbourState::asked || is_near;
  const Shape& shape = held.objects[still_ + part].shape;
  const Vec3 middle = origin_of(shape);
  const Pose& pose = held.objects[still_ + part].pose;
  Vec3 from = middle + memory.proxy;
  if (before == NeighbourState::far)
    from = seen_from(contacts.steps == counters_.steps ? pose : followed_[part].before,
                     contacts.tool.position);
  const Vec3 way_from = from - middle, way_to = seen_from(pose, position) - middle;
  if (!is_near && nearest_on_segment(way_from, way_to, Vec3::Zero()).point.squaredNorm() >
                      held.reach.square(part))
    return false;
  if (before == NeighbourState::far) approach_from(shape, from, memory);
  return true;
}

/// Rebuilds the list of the objects near the tool. An object that leaves the list has no force: it
/// was asked after it came out of reach. Otherwise it stays in the list.
void World::update_neighbours(const MovedView& held, const Vec3& position, TouchMemory& memory,
                              BodyContactState& contacts) const noexcept {
  NeighbourList& near = contacts.near;
  near.parts.clear();
  for (std::size_t i = 0; i < parts_; ++i) {
    const NeighbourState before = contacts.nearness[i];
    const bool is_near = followed_[i].way
                             ? comes_near(held, i, position, contacts, memory[still_ + i].feature)
                             : before == NeighbourState::asked || held.reach.is_near(i, position);
    if (!is_near) {
      contacts.nearness[i] = NeighbourState::far;
      continue;
    }
    if (before == NeighbourState::far) contacts.nearness[i] = NeighbourState::near;
    near.parts.push_back(static_cast<std::uint32_t>(i));
  }
  held.reach.mark(near, position);
}

/// If neither the tool nor its way is in reach of an object that does not hold the tool, remembers
/// the tool's place as a query would, and returns true.
bool World::passes_by(const MovedView& held, std::size_t part, const Vec3& position,
                      FeatureMemory& memory) const noexcept {
  if (memory.side != 0) return false;
  const Shape& shape = held.objects[still_ + part].shape;
  const Vec3 own = seen_from(held.objects[still_ + part].pose, position);
  if (memory.tracked &&
      !(nearest_on_segment(memory.proxy, own - origin_of(shape), Vec3::Zero()).point.squaredNorm() >
        held.reach.square(part)))
    return false;
  approach_from(shape, own, memory);
  return true;
}

/// Stores the answer of a moving object in the contacts and adds it to `sum`. An object that went
/// out of reach is asked once more, and lets go.
void World::ask(const MovedView& held, std::size_t part, const Tool& tool, TouchMemory& memory,
                BodyContactState& contacts, Command& sum) const noexcept {
  const std::size_t object = still_ + part;
  NeighbourState& nearness = contacts.nearness[part];
  const bool follows = followed_[part].way;
  const bool outside = held.reach.is_outside(part, tool.position);
  if (outside && (follows ? passes_by(held, part, tool.position, memory[object].feature)
                          : nearness != NeighbourState::asked)) {
    nearness = NeighbourState::near;
    return;
  }
  nearness = outside && !follows ? NeighbourState::near : NeighbourState::asked;
  const Vec3 against = tool.velocity - velocity_at(object, tool.position);
  const Command answer = trust_ * contacts.pace.trust(time()) *
                         feltwire::touch(held.objects[object], {tool.position, against},
                                         memory[object], held.view->tool().radius);
  contacts.forces[part] = answer.force();
  if (outside && memory[object].feature.side == 0)
    nearness = NeighbourState::near;  // it has let go
  sum.elastic += answer.elastic;
  sum.frictional += answer.frictional;
}

/// Asks the moving objects that are near.
void World::ask_near(const Tool& tool, TouchMemory& memory, BodyContactState& contacts,
                     Command& sum) const noexcept {
  const MovedView& held = held_[contacts.held];
  if (!held.reach.holds(contacts.near, tool.position))
    update_neighbours(held, tool.position, memory, contacts);
  for (const std::uint32_t part : contacts.near.parts) ask(held, part, tool, memory, contacts, sum);
  contacts.steps = counters_.steps;
}

Command World::touch(const Tool& tool, TouchMemory& memory,
                     BodyContactState& contacts) const noexcept {
  if (!tool.position.allFinite() || !tool.velocity.allFinite() ||
      memory.size() != objects().size() || contacts.nearness.size() != parts_) [[unlikely]]
    return {};
  const double way = contacts.placed ? length(Vec3(tool.position - contacts.tool.position)) : 0.0;
  contacts.placed = true;
  const bool jumped = !contacts.pace.follow(way, time());
  if (jumped || contacts.resets != counters_.resets) forget_moving(contacts, memory);
  Command sum = view(contacts.held).touch_still(tool, memory);
  ask_near(tool, memory, contacts, sum);
  if (!view(contacts.held).guides().empty()) view(contacts.held).add_guides(tool, sum);
  contacts.tool = tool;
  contacts.fresh = true;
  return sum.finite() ? sum : Command{};
}

}  // namespace feltwire
