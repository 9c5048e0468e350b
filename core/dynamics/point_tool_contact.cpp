#include "core/dynamics/point_tool_contact.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/geometry/segment.hpp"

namespace feltwire {
namespace {

Vec3 seen_from(const Pose& pose, const Vec3& position) {
  return pose.orientation.conjugate() * (position - pose.position);
}

/// Asks the moving objects near a tool for their forces.
class NeighbourQuery {
 public:
  NeighbourQuery(const MovingObjects& objects, const WorldMoment& moment, TouchMemory& memory,
                 BodyContactState& contacts) noexcept
      : objects_(objects),
        moved_(objects.views()[contacts.held]),
        moment_(moment),
        memory_(memory),
        contacts_(contacts) {}

  /// The moving objects begin without a force.
  void forget() noexcept {
    for (std::size_t i = objects_.still(); i < memory_.size(); ++i) memory_[i] = {};
    std::ranges::fill(contacts_.forces, Vec3::Zero());
    std::ranges::fill(contacts_.nearness, NeighbourState::far);
    contacts_.near.forget();
    contacts_.resets = moment_.resets;
  }

  /// Adds the answers of the moving objects that are near to `sum`.
  void add_answers(const Tool& tool, Command& sum) noexcept {
    if (!moved_.reach.holds(contacts_.near, tool.position)) update_neighbours(tool.position);
    for (const std::uint32_t part : contacts_.near.parts) ask(part, tool, sum);
    contacts_.steps = moment_.steps;
  }

 private:
  const Object& object(std::size_t part) const { return moved_.objects[objects_.still() + part]; }
  FeatureMemory& feature(std::size_t part) { return memory_[objects_.still() + part].feature; }

  /// Whether the tool is near an object that follows its way, or has passed it since the last query
  /// at contacts_.tool. The way is the one relative to the object. For an object that was in no
  /// list, the way begins where the object's pose of one step ago saw the tool; older poses are
  /// unknown.
  bool comes_near(std::size_t part, const Vec3& position) noexcept {
    const bool is_near = moved_.reach.is_near(part, position), known = contacts_.near.known();
    const NeighbourState before = contacts_.nearness[part];
    if (before == NeighbourState::asked || !known)
      return before == NeighbourState::asked || is_near;
    const Shape& shape = object(part).shape;
    const Vec3 middle = origin_of(shape);
    const Pose& pose = object(part).pose;
    FeatureMemory& memory = feature(part);
    Vec3 from = middle + memory.proxy;
    if (before == NeighbourState::far)
      from = seen_from(contacts_.steps == moment_.steps ? pose : objects_.previous_pose(part),
                       contacts_.tool.position);
    const Vec3 way_from = from - middle, way_to = seen_from(pose, position) - middle;
    if (!is_near && nearest_on_segment(way_from, way_to, Vec3::Zero()).point.squaredNorm() >
                        moved_.reach.square(part))
      return false;
    if (before == NeighbourState::far) approach_from(shape, from, memory);
    return true;
  }

  /// Rebuilds the list of the objects near the tool. An object that leaves the list has no force:
  /// it was asked after it came out of reach. Otherwise it stays in the list.
  void update_neighbours(const Vec3& position) noexcept {
    NeighbourList& near = contacts_.near;
    near.parts.clear();
    for (std::size_t i = 0; i < objects_.moving(); ++i) {
      const NeighbourState before = contacts_.nearness[i];
      const bool is_near = objects_.follows_way(i) ? comes_near(i, position)
                                                   : before == NeighbourState::asked ||
                                                         moved_.reach.is_near(i, position);
      if (!is_near) {
        contacts_.nearness[i] = NeighbourState::far;
        continue;
      }
      if (before == NeighbourState::far) contacts_.nearness[i] = NeighbourState::near;
      near.parts.push_back(static_cast<std::uint32_t>(i));
    }
    moved_.reach.mark(near, position);
  }

  /// If neither the tool nor its way is in reach of an object that does not hold the tool,
  /// remembers the tool's place as a query would, and returns true.
  bool passes_by(std::size_t part, const Vec3& position) noexcept {
    FeatureMemory& memory = feature(part);
    if (memory.side != 0) return false;
    const Shape& shape = object(part).shape;
    const Vec3 own = seen_from(object(part).pose, position);
    if (memory.tracked && !(nearest_on_segment(memory.proxy, own - origin_of(shape), Vec3::Zero())
                                .point.squaredNorm() > moved_.reach.square(part)))
      return false;
    approach_from(shape, own, memory);
    return true;
  }

  /// Stores the answer of a moving object in the contacts and adds it to `sum`. An object that went
  /// out of reach is asked once more, and lets go.
  void ask(std::size_t part, const Tool& tool, Command& sum) noexcept {
    const std::size_t object = objects_.still() + part;
    NeighbourState& nearness = contacts_.nearness[part];
    const bool follows = objects_.follows_way(part);
    const bool outside = moved_.reach.is_outside(part, tool.position);
    if (outside && (follows ? passes_by(part, tool.position) : nearness != NeighbourState::asked)) {
      nearness = NeighbourState::near;
      return;
    }
    nearness = outside && !follows ? NeighbourState::near : NeighbourState::asked;
    const Vec3 against = tool.velocity - objects_.velocity_at(object, tool.position);
    const Command answer = moment_.trust * contacts_.pace.trust(moment_.now) *
                           touch(moved_.objects[object], {tool.position, against}, memory_[object],
                                 moved_.view->tool().radius);
    contacts_.forces[part] = answer.force();
    if (outside && memory_[object].feature.side == 0)
      nearness = NeighbourState::near;  // it has let go
    sum.elastic += answer.elastic;
    sum.frictional += answer.frictional;
  }

  const MovingObjects& objects_;
  const MovedView& moved_;
  const WorldMoment& moment_;
  TouchMemory& memory_;
  BodyContactState& contacts_;
};

bool fits(const MovingObjects& objects, const TouchMemory& memory,
          const BodyContactState& contacts) {
  return memory.size() == objects.still() + objects.moving() &&
         contacts.nearness.size() == objects.moving();
}

}  // namespace

Command touch(const MovingObjects& objects, const WorldMoment& moment, const Tool& tool,
              TouchMemory& memory, BodyContactState& contacts) noexcept {
  if (!tool.position.allFinite() || !tool.velocity.allFinite() || !fits(objects, memory, contacts))
      [[unlikely]]
    return {};
  const double way = contacts.placed ? length(Vec3(tool.position - contacts.tool.position)) : 0.0;
  contacts.placed = true;
  const bool jumped = !contacts.pace.follow(way, moment.now);
  NeighbourQuery neighbours(objects, moment, memory, contacts);
  if (jumped || contacts.resets != moment.resets) neighbours.forget();
  const ToolView& view = *objects.views()[contacts.held].view;
  Command sum = view.touch_still(tool, memory);
  neighbours.add_answers(tool, sum);
  if (!view.guides().empty()) view.add_guides(tool, sum);
  contacts.tool = tool;
  contacts.fresh = true;
  return sum.finite() ? sum : Command{};
}

bool hold_still(const MovingObjects& objects, const WorldMoment& moment, TouchMemory& memory,
                BodyContactState& contacts) noexcept {
  if (!fits(objects, memory, contacts)) [[unlikely]]
    return false;
  NeighbourQuery neighbours(objects, moment, memory, contacts);
  if (contacts.resets != moment.resets) {
    contacts.fresh = false;
    neighbours.forget();
  }
  if (!contacts.fresh) {
    Command unused;
    neighbours.add_answers({contacts.tool.position, Vec3::Zero()}, unused);
  }
  contacts.fresh = false;
  return true;
}

}  // namespace feltwire
