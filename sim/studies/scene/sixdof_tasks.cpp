#include "sim/studies/scene/sixdof_tasks.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/mesh/mesh_distance.hpp"

namespace feltwire {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
const Vec3 kX = Vec3::UnitX(), kY = Vec3::UnitY(), kZ = Vec3::UnitZ();

/// Returns 0 at the start of a task, 1 in the middle and 0 at the end. `share`: elapsed fraction of
/// the task. The slope is zero at the start and at the end.
double there_and_back(double share) { return 0.5 - 0.5 * std::cos(kTurn * share); }

SixDofTask peg(const std::string& name, double play) {
  const Vec3 half(0.01, 0.01, 0.02);
  SixDofTask task;
  task.name = name;
  task.tool = box_solid(half);
  task.box = Box{Vec3(half.x() + 0.5 * play, half.y() + 0.5 * play, 0.1)};
  task.side = Side::inside;
  task.contact_area = 4.0 * half.x() * half.z();
  task.press = kX;
  task.device = [](double share) {
    // [m] and [rad] amplitudes, and the number of oscillations.
    constexpr double kSway = 1e-3, kTilt = 0.02, kSways = 2.0;
    const double size = there_and_back(share), phase = kSways * kTurn * share;
    return moved({}, size * kSway * Vec3(std::sin(phase), std::cos(phase), 2.0 * std::sin(phase)),
                 size * kTilt * Vec3(std::cos(phase), std::sin(phase), 0.0));
  };
  return task;
}

SixDofTask gears() {
  // [rad] Roll around the other gear, and an extra turn that presses the teeth together.
  constexpr double kRoll = 0.25, kTwist = 0.04;
  const GearShape gear;
  SixDofTask task;
  task.name = "gears";
  task.tool = task.solid = gear_solid(gear);
  task.contact_area = 4e-5;
  task.press = kY;
  // Turned by `gap`, this gear has a tooth space at the place of a tooth of the other gear.
  const double gap = std::numbers::pi / gear.teeth, apart = 2.0 * gear.pitch_radius();
  task.device = [gap, apart](double share) {
    const double size = there_and_back(share), roll = kRoll * std::sin(kTurn * share) * size;
    return Pose{apart * Vec3(std::cos(roll), std::sin(roll), 0.0),
                Quaternion(Eigen::AngleAxisd(gap + 2.0 * roll + kTwist * size, kZ))};
  };
  return task;
}

SixDofTask chain() {
  constexpr double kFree = 0.5e-3;  // [m] initial distance from contact
  const LinkShape link;
  SixDofTask task;
  task.name = "chain";
  task.tool = task.solid = link_solid(link);
  task.contact_area = link.bar * link.bar;
  task.press = kX;
  const double taut = link.length - 2.0 * link.bar;
  task.device = [taut](double share) {
    constexpr double kPull = 1.5e-3, kSway = 2e-3, kTilt = 0.1;  // [m], [rad] amplitudes
    const double size = there_and_back(share), phase = 2.0 * kTurn * share;
    const Pose begin{(taut - kFree) * kX, Quaternion(Eigen::AngleAxisd(0.25 * kTurn, kX))};
    return moved(begin, size * Vec3(kPull, kSway * std::sin(phase), 0.0),
                 size * kTilt * Vec3(std::sin(phase), 0.0, std::cos(phase)));
  };
  return task;
}

SixDofTask edge() {
  // [m] Start height above the table, depth of the press, start in x, length of the path in x.
  constexpr double kAbove = 0.5e-3, kPress = 1e-3, kBegin = -0.05, kWay = 0.06;
  const Vec3 half(0.03, 0.02, 0.01), table(0.1, 0.1, 0.02);
  SixDofTask task;
  task.name = "edge";
  task.tool = box_solid(half);
  task.box = Box{table};
  task.place.position = Vec3(-table.x(), 0.0, -table.z());
  task.contact_area = 4.0 * half.x() * half.y();
  task.press = -kZ;
  task.device = [half](double share) {
    constexpr double kSoon = 5.0;  // the tool is down after 10 % of the task
    const double down = there_and_back(std::min({0.5, kSoon * share, kSoon * (1.0 - share)}));
    return Pose{Vec3(kBegin + kWay * there_and_back(share), 0.0,
                     half.z() + kAbove - (kAbove + kPress) * down),
                Quaternion::Identity()};
  };
  return task;
}

SixDofTask ridge() {
  // [m] Half size of the tool, and half the length of its path in x.
  constexpr double kHalf = 0.01, kSide = 0.012;
  SixDofTask task;
  task.name = "ridge";
  task.tool = box_solid(Vec3::Constant(kHalf));
  task.box = Box{Vec3(kHalf, 2.0 * kHalf, kHalf)};
  const Quaternion on_edge(Eigen::AngleAxisd(0.125 * kTurn, kY));
  task.place.orientation = on_edge;
  task.contact_area = 1e-5;
  task.press = -kZ;
  task.device = [on_edge](double share) {
    // [m] Length of the path, and the depth of the tool's lower edge below the upper edge of the
    // solid.
    constexpr double kAcross = 2.0 * kSide, kLow = 4e-3;
    const double height = 2.0 * std::numbers::sqrt2 * kHalf - kLow;
    return Pose{Vec3(kAcross * there_and_back(share) - kSide, 0.0, height), on_edge};
  };
  return task;
}

/// Moves the tool along -x from a distant position. Returns the x [m] of the first contact with the
/// solid.
double first_contact(const SixDofTask& task, const Quaternion& orientation) {
  constexpr double kFar = 0.15, kStep = 1e-4;
  const PolygonBody body = polygon_body(task.tool.parts, {solid_parts_of(task)});
  Object object;
  object.material.stiffness = 1.0;
  PartPairs near;
  double at = kFar;
  for (;; at -= kStep) {
    const Pose pose{at * kX, orientation};
    update_part_pairs(body, std::span(&object, 1), pose, false, near);
    if (polygon_contact(body, std::span(&object, 1), 1.0, near, pose).energy > 0.0) return at;
  }
}

SixDofTask bunny(const std::string& name, double tolerance, std::size_t triangles) {
  // [m] Initial distance, depth of the press and amplitude of the slide. [rad] Tilt.
  constexpr double kFree = 0.5e-3, kPress = 3e-3, kSlide = 4e-3, kTilt = 0.05;
  SixDofTask task;
  task.name = name;
  task.tool = task.solid = bunny_solid(tolerance, triangles);
  task.contact_area = 1e-3;
  task.press = -kX;
  task.time = 0.4;
  const Quaternion aslant(Eigen::AngleAxisd(1.0, Vec3(1.0, 2.0, 0.5).normalized()));
  const Pose begin{(first_contact(task, aslant) + kFree) * kX, aslant};
  task.device = [begin](double share) {
    const double size = there_and_back(share), phase = kTurn * share;
    return moved(begin, size * Vec3(-kFree - kPress, kSlide * std::sin(phase), 0.0),
                 size * kTilt * Vec3(0.0, std::sin(phase), std::cos(phase)));
  };
  return task;
}

struct NamedTask {
  std::string name;
  /// Makes the task. `tolerance` [m] and `triangles` (0: unchanged) are the arguments of
  /// bunny_solid().
  std::function<SixDofTask(const std::string& name, double tolerance, std::size_t triangles)> made;
  bool fine = false;
};

std::vector<NamedTask> named_tasks() {
  return {{"peg 0.5", [](const auto& name, auto...) { return peg(name, 0.5e-3); }},
          {"peg 0.1", [](const auto& name, auto...) { return peg(name, 0.1e-3); }},
          {"gears", [](auto...) { return gears(); }},
          {"chain", [](auto...) { return chain(); }},
          {"edge", [](auto...) { return edge(); }},
          {"ridge", [](auto...) { return ridge(); }},
          {"bunny", bunny},
          {"bunny 20k", bunny, true}};
}

}  // namespace

std::vector<std::string> sixdof_task_names() {
  std::vector<std::string> names;
  for (const NamedTask& task : named_tasks()) names.push_back(task.name);
  return names;
}

std::vector<SixDofTask> sixdof_tasks(double bunny_tolerance, std::size_t fine_triangles,
                                     const std::vector<std::string>& names) {
  std::vector<SixDofTask> tasks;
  for (const NamedTask& task : named_tasks()) {
    const bool asked = names.empty() || std::ranges::find(names, task.name) != names.end();
    if (asked && (!task.fine || fine_triangles > 0))
      tasks.push_back(task.made(task.name, bunny_tolerance, task.fine ? fine_triangles : 0));
  }
  return tasks;
}

SolidParts solid_parts_of(const SixDofTask& task) {
  return task.box ? solid_parts(*task.box, task.side) : solid_parts(task.solid.parts);
}

Object object_of(const SixDofTask& task, double stiffness, double steps) {
  Object object;
  object.name = task.name;
  object.pose = task.place;
  object.felt_from = task.side;
  object.material.stiffness = stiffness;
  if (task.box) {
    object.shape = *task.box;
  } else {
    TriangleMesh mesh(task.solid.surface);
    const double resolution = mesh.report().size / steps;
    object.shape = Grid{std::make_shared<const DistanceGrid<float>>(
        solid_of(std::move(mesh)), GridOptions{.resolution = resolution})};
  }
  return object;
}

}  // namespace feltwire
