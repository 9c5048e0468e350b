#include "core/prefetched_geometry/contact_trial.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {
namespace {

using Visit = std::function<bool(const TrialTick&)>;

constexpr double kStep = 0.25e-3;  // [m] movement per tick of a fast hand

/// Calls go(position) after each step on the way from `from` to `to`. Returns false if go() returns
/// false.
template <class Go>
bool each_step(const Vec3& from, const Vec3& to, int most, Go go) {
  const double way = length(Vec3(to - from));
  const int steps = std::min(most, static_cast<int>(std::ceil(way / kStep)));
  for (int n = 1; n <= steps; ++n)
    if (!go(Vec3(from + std::min(1.0, n * kStep / way) * (to - from)))) return false;
  return true;
}

/// Tries a point on a mesh. The first tick takes its contact memory from a local model, as after an
/// interrupted tick.
bool try_way(const PrefetchedSurfaces& surfaces, const TrialWay& way, const Visit& visit) {
  constexpr int kMostSteps = 32;
  const Material material{.stiffness = 1000.0, .static_friction = 0.5, .dynamic_friction = 0.4};
  SurfacePatch patch;
  patch.object = way.object;
  patch.point = patch.anchor = way.from;
  patch.normal = direction(Vec3(way.from - way.into));
  patch.touching = patch.whole = true;
  ContactMemory memory, after;
  bool adopted = true;
  const auto tick = [&](const Vec3& place) {
    const std::function<void(WorkLimit&)> evaluate = [&](WorkLimit& work) {
      after = adopted ? surfaces.memory_of(patch, way.from, &work) : memory;
      if (!work.cut()) surfaces.touch(way.object, material, {place, Vec3::Zero()}, after, &work);
    };
    after = memory;
    if (!visit({way.object, evaluate})) return false;
    memory = after;
    adopted = false;
    return true;
  };
  return tick(way.from) && each_step(way.from, way.into, kMostSteps, tick) &&
         each_step(way.into, way.along, kMostSteps, tick);
}

/// Moves the tool to its first contact. `meets` stays false if the tool begins in a solid or finds
/// no contact.
struct Approach {
  const PrefetchedTool& body;
  const TrialWay& way;
  const Visit& visit;
  Pose pose;
  bool meets = false;

  /// Moves the tool. Returns false if visit() returns false.
  bool run() {
    constexpr int kMostSteps = 64;
    constexpr double kTouching = 1e-4;  // [m] A tool with a smaller clearance is in contact.
    pose.position = way.from;
    const Vec3 ahead = direction(Vec3(way.into - way.from));
    for (int n = 0; n < kMostSteps; ++n) {
      ShellContact contact;
      const std::function<void(WorkLimit&)> evaluate = [&](WorkLimit& work) {
        contact = body.solids->contact(pose, &work);
      };
      if (!visit({way.object, evaluate})) return false;
      if (contact.touching > 0 && n == 0) return true;
      meets = contact.touching > 0 || contact.clearance < kTouching;
      const double left = length(Vec3(way.into - pose.position));
      if (meets || !(left > kTouching)) return true;
      pose.position += std::min(contact.clearance, left) * ahead;
    }
    meets = true;
    return true;
  }
};

bool try_way(const PrefetchedTool& body, const TrialWay& way, double period, const Visit& visit) {
  constexpr int kMostSteps = 12;
  Approach approach{body, way, visit, {}};
  if (!approach.run()) return false;
  if (!approach.meets) return true;
  BodyMemory memory, after;
  memory.placed = true;
  memory.pose = approach.pose;
  const auto tick = [&](const Vec3& place) {
    const std::function<void(WorkLimit&)> evaluate = [&](WorkLimit& work) {
      after = memory;
      after.known = false;
      const CoupledTool tool{body.coupling, body.radius, false, &body.inertia, &work};
      step_coupled_tool(tool, *body.solids, {place, {1, 0, 0, 0}}, period, after);
    };
    after = memory;
    if (!visit({way.object, evaluate})) return false;
    memory = after;
    return true;
  };
  const Vec3 begins = approach.pose.position;
  const Vec3 ends = begins + kMostSteps * kStep * direction(Vec3(way.into - way.from));
  return each_step(begins, ends, kMostSteps, tick) &&
         each_step(ends, ends + (way.along - way.into), kMostSteps, tick);
}

}  // namespace

void try_contact(const FetchedScene& scene, double servo_period, const Visit& visit) {
  if (scene.surfaces != nullptr)
    for (const TrialWay& way : scene.surfaces->trial_ways())
      if (!try_way(*scene.surfaces, way, visit)) return;
  if (scene.body != nullptr)
    for (const TrialWay& way : scene.body->ways)
      if (!try_way(*scene.body, way, servo_period, visit)) return;
}

}  // namespace feltwire
