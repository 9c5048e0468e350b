#include "sim/studies/scene/trade_tools.hpp"

#include <cmath>
#include <memory>
#include <numbers>

#include "core/base/splitmix.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"
#include "sim/measure/cost.hpp"

namespace feltwire {
namespace {

constexpr double kRadian = std::numbers::pi / 180.0;  // [rad] in a degree
constexpr int kSegments = 256;                        // number of segments of a circle
constexpr std::size_t kCostLaps = 3;
constexpr double kPeriod = 1e-3;  // [s] length of a step

const Box kBody{Vec3(0.03, 0.02, 0.01)};
const Cylinder kRod{0.01, 0.015}, kHole{0.0102, 0.03};

struct Task {
  std::string name;
  TriangleSoup surface;
  Object object;
  Pose pose;          // pose around which the tool moves
  double area = 0.0;  // [m^2] contact area
  Vec3 slide;         // [m] amplitude of the translation
  Vec3 turn;          // [rad] amplitude of the rotation
  Vec3 away;          // [m] from `pose` to a position without contact
};

Object object_of(const Shape& solid, double resolution, Side side) {
  constexpr double kStiffness = 1000.0;  // [N/m]
  Object object;
  object.name = "solid";
  object.shape = Grid{std::make_shared<const DistanceGrid<float>>(
      solid_of(solid), GridOptions{.resolution = resolution})};
  object.felt_from = side;
  object.material.stiffness = kStiffness;
  return object;
}

Quaternion about(const Vec3& axis, double degrees) {
  return Quaternion(Eigen::AngleAxisd(degrees * kRadian, axis));
}

std::vector<Task> tasks() {
  constexpr double kFace = 4.0 * 0.03 * 0.02;  // [m^2] area of the largest face of the box
  const Box plate{Vec3(0.08, 0.08, 0.02)};
  const Object on_plate = object_of(plate, 1e-3, Side::outside);
  const TriangleSoup box = tessellate(kBody, kSegments);
  const Vec3 aside(5e-3, 5e-3, 0.0), up = 0.1 * Vec3::UnitZ();

  Task flat{"flat",
            box,
            on_plate,
            {Vec3(0.0, 0.0, 0.029), Quaternion::Identity()},
            kFace,
            aside,
            Vec3(0.0, 0.0, 1.0),
            up};
  Task edge = flat;
  edge.name = "edge";
  const double tilt = 30.0;  // [deg]
  edge.pose.orientation = about(Vec3::UnitY(), tilt);
  const double reach = 0.03 * std::sin(tilt * kRadian) + 0.01 * std::cos(tilt * kRadian);
  edge.pose.position.z() = 0.02 + reach - 2e-3;
  Task peg{"peg",
           tessellate(kRod, kSegments),
           object_of(kHole, 0.5e-3, Side::inside),
           {Vec3(3e-4, 0.0, 0.0), about(Vec3::UnitY(), 2.0)},
           kFace,
           Vec3(1e-4, 1e-4, 5e-3),
           Vec3(0.0, 0.0, 1.0),
           Vec3::Zero()};
  return {flat, edge, peg};
}

/// Returns the random number with the index i, between -1 and 1.
double random(std::uint64_t i) {
  return static_cast<double>(splitmix::draw(1, i) >> 11) * 0x1p-52 - 1.0;
}

Pose pose_near(const Task& task, int n) {
  const auto draw = [n](std::uint64_t k) { return random(6 * static_cast<std::uint64_t>(n) + k); };
  return moved(task.pose, task.slide.cwiseProduct(Vec3(draw(0), draw(1), draw(2))),
               task.turn.cwiseProduct(Vec3(draw(3), draw(4), draw(5))));
}

std::vector<ShellContact> contacts(const Task& task, std::size_t points, int poses) {
  const PointShell shell = point_shell(task.surface, points);
  std::vector<ShellContact> all(static_cast<std::size_t>(poses));
  for (int n = 0; n < poses; ++n)
    add_contact(shell, pose_near(task, n), task.object, task.area,
                all[static_cast<std::size_t>(n)]);
  return all;
}

void compare(const std::vector<ShellContact>& felt, const std::vector<ShellContact>& reference,
             double radius, ToolsCell& cell) {
  double force = 0.0, torque = 0.0, whole = 0.0;
  for (std::size_t n = 0; n < felt.size(); ++n) {
    const Vec6 error = felt[n].wrench - reference[n].wrench;
    force += error.head<3>().squaredNorm();
    torque += error.tail<3>().squaredNorm();
    whole += reference[n].wrench.head<3>().squaredNorm();
    cell.looked_at += static_cast<double>(felt[n].looked_at) / static_cast<double>(felt.size());
    cell.touching += static_cast<double>(felt[n].touching) / static_cast<double>(felt.size());
  }
  cell.force_error = std::sqrt(force / whole);
  cell.torque_error = std::sqrt(torque / whole) / radius;
}

/// Returns the poses of a hand that oscillates at 2 Hz. The middle is the pose of the task, shifted
/// by `from` [m]. The amplitude is a third of the slide and turn of the task.
std::vector<Pose> swaying(const Task& task, const Vec3& from, int steps) {
  constexpr double kTurns = 2.0, kShare = 1.0 / 3.0;
  std::vector<Pose> poses;
  for (int n = 0; n < steps; ++n) {
    const double s = kShare * std::sin(2.0 * std::numbers::pi * kTurns * kPeriod * n);
    poses.push_back(moved(task.pose, from + s * task.slide, s * task.turn));
  }
  return poses;
}

/// Returns the CPU time [ns] of a step. Sets `evaluations` to the mean number of contact
/// computations in a step.
double step_cost(const BodyTool& tool, const Object& object, const std::vector<Pose>& hand,
                 double& evaluations) {
  BodyMemory memory;
  std::size_t counted = 0;
  const double ns = cost_ns(
      hand.size(),
      [&](std::size_t n) {
        counted += step_body(tool, std::span(&object, 1), hand[n], kPeriod, memory).evaluations;
      },
      kCostLaps);
  evaluations = static_cast<double>(counted) / static_cast<double>(kCostLaps * hand.size());
  return ns;
}

}  // namespace

std::vector<ToolsCell> run_trade_tools(const ToolsGrid& grid) {
  std::vector<ToolsCell> cells;
  for (const Task& task : tasks()) {
    const auto reference = contacts(task, grid.reference, grid.poses);
    for (const std::size_t points : grid.points) {
      ToolsCell cell;
      cell.task = task.name;
      cell.points = points;
      const BodyTool tool(point_shell(task.surface, points), {}, task.area);
      compare(contacts(task, points, grid.poses), reference, tool.shell().radius, cell);
      cell.contact_ns =
          step_cost(tool, task.object, swaying(task, Vec3::Zero(), grid.steps), cell.evaluations);
      double unused = 0.0;
      if (!task.away.isZero(0.0))
        cell.far_ns = step_cost(tool, task.object, swaying(task, task.away, grid.steps), unused);
      cells.push_back(std::move(cell));
    }
  }
  return cells;
}

}  // namespace feltwire
