#include "sim/studies/scene/trade_mass.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"
#include "sim/studies/scene/damped_inertia.hpp"

namespace feltwire {
namespace {

constexpr double kMassPeriod = 1e-3, kMassGravity = 9.81;  // [s] servo period, [m/s^2] gravity
constexpr double kMassContact = 1000.0;                    // [N/m] stiffness of the plane
const Vec3 kMassHalf(0.03, 0.02, 0.01);                    // [m] half extents of the tool's box
constexpr double kMassFace = 4.0 * 0.03 * 0.02;  // [m^2] area of the largest face of the box
constexpr std::size_t kMassPoints = 200, kMassCostPoints = 1000;
const std::vector<std::string> kMassWays = {"none", "implicit", "midpoint"};
const std::vector<std::string> kMassTasks = {"sway", "tap"};

BodyTool mass_tool(const std::string& way, double mass, const ToolCoupling& coupling,
                   std::size_t points) {
  ToolInertia inertia;
  if (way != "none") {
    inertia.mass = mass;
    const Vec3 squares = kMassHalf.cwiseProduct(kMassHalf);
    inertia.inertia =
        mass / 3.0 * (Vec3::Constant(squares.sum()) - squares).asDiagonal().toDenseMatrix();
    inertia.gravity = Vec3(0.0, 0.0, -kMassGravity);
    inertia.integration = way == "midpoint" ? ToolIntegration::midpoint : ToolIntegration::implicit;
  }
  return {point_shell(tessellate(Box{kMassHalf}, 3), points), coupling, kMassFace, inertia};
}

Object mass_plane(double stiffness) {
  Object plane;
  plane.name = "plane";
  plane.shape = Plane{};
  plane.material.stiffness = stiffness;
  return plane;
}

/// Returns the pose of the device in a task at `time` [s].
Pose device_at(const std::string& task, double time) {
  const double turn = 2.0 * std::numbers::pi * time;
  Pose device;
  if (task == "sway")
    device.position = Vec3(0.05 * (1.0 - std::cos(2.0 * turn)), 0.0, 0.5);
  else
    device.position = Vec3(0.0, 0.0, 0.01 + 0.01 * std::cos(3.0 * turn));
  return device;
}

/// Returns a tool with a critically damped coupling, and with a force limit that is too high to
/// act.
BodyTool damped_tool(const std::string& way, double mass, std::size_t points) {
  const BodyTool tool = mass_tool(way, mass, {.max_force = 1000.0}, points);
  return {tool.shell(), tool.coupling(), kMassFace,
          critically_damped(tool.inertia(), tool.coupling())};
}

/// Returns the force [N] on the hand at the end of each of `count` periods. Each period has `finer`
/// integration steps.
std::vector<Vec3> felt(const BodyTool& tool, const std::string& task, double period, int count,
                       int finer) {
  const Object plane = mass_plane(kMassContact);
  const double h = period / finer;
  BodyMemory memory;
  std::vector<Vec3> forces;
  step_body(tool, std::span(&plane, 1), device_at(task, 0.0), h, memory);
  for (int n = 1; n <= count; ++n) {
    Command command;
    for (int k = 1; k <= finer; ++k)
      command = step_body(tool, std::span(&plane, 1), device_at(task, h * ((n - 1) * finer + k)), h,
                          memory)
                    .command;
    forces.push_back(command.force());
  }
  return forces;
}

double rms_error(const std::vector<Vec3>& forces, const std::vector<Vec3>& reference) {
  double off = 0.0, whole = 0.0;
  for (std::size_t n = 0; n < forces.size(); ++n) {
    off += (forces[n] - reference[n]).squaredNorm();
    whole += reference[n].squaredNorm();
  }
  return std::sqrt(off / whole);
}

void measure_accuracy(const MassGrid& grid, std::vector<MassAccuracy>& cells) {
  for (const std::string& task : kMassTasks)
    for (const double mass : grid.masses)
      for (const double period : grid.periods) {
        const auto count = static_cast<int>(std::lround(grid.task_time / period));
        const int finer =
            std::max(1, static_cast<int>(std::lround(grid.finer * period / kMassPeriod)));
        const auto reference =
            felt(damped_tool("midpoint", mass, kMassPoints), task, period, count, finer);
        for (const std::string& way : kMassWays)
          cells.push_back(
              {task, way, mass, period,
               rms_error(felt(damped_tool(way, mass, kMassPoints), task, period, count, 1),
                         reference)});
      }
}

struct Thrown {
  const BodyTool& tool;
  const Object plane;
  const Pose device{Vec3(0.0, 0.0, 0.01), Quaternion::Identity()};
  BodyMemory memory = {};

  /// Returns the total energy [J]. The potential energy of the tool is zero if its centre of mass
  /// is at the height of the device.
  double energy(const BodyStep& step) const {
    const ToolInertia& i = tool.inertia();
    return step.stored + step.kinetic -
           i.mass * i.gravity.dot(center_of_mass(i, memory.pose) - device.position);
  }
  BodyStep step() { return step_body(tool, std::span(&plane, 1), device, kMassPeriod, memory); }
};

/// Returns the energy [J] of the tool at rest. Simulates `steps` steps of a critically damped tool,
/// which is then at rest.
double rest_energy(const std::string& way, double stiffness, double mass, int steps) {
  if (way == "none") return 0.0;
  const BodyTool calm = damped_tool("implicit", mass, kMassPoints);
  Thrown thrown{calm, mass_plane(stiffness)};
  BodyStep last;
  for (int n = 0; n < steps; ++n) last = thrown.step();
  return thrown.energy(last);
}

MassStability thrown_at(const std::string& way, double stiffness, double mass, double time) {
  constexpr double kSpeed = 0.5, kSlow = 1e-3, kTilt = 5.0 * std::numbers::pi / 180.0;
  const auto steps = static_cast<int>(std::lround(time / kMassPeriod));
  const BodyTool tool = mass_tool(way, mass, {.max_force = 1000.0}, kMassPoints);
  Thrown thrown{tool, mass_plane(stiffness)};
  thrown.memory.placed = true;
  thrown.memory.pose = {Vec3(0.0, 0.0, 0.02), Quaternion(Eigen::AngleAxisd(kTilt, Vec3::UnitY()))};
  thrown.memory.velocity.linear.z() = -kSpeed;
  // A step with a duration of zero returns the initial energy.
  const BodyStep first =
      step_body(tool, std::span(&thrown.plane, 1), thrown.device, 0.0, thrown.memory);
  const double rest = rest_energy(way, stiffness, mass, 2 * steps);
  const double begins = thrown.energy(first) - rest;
  MassStability cell{way, stiffness, mass};
  int moved_at = 0;
  for (int n = 1; n <= steps; ++n) {
    const Vec3 before = thrown.memory.pose.position;
    const BodyStep now = thrown.step();
    cell.left = (thrown.energy(now) - rest) / begins;
    cell.most = std::max(cell.most, cell.left);
    const double speed = (thrown.memory.pose.position - before).norm() / kMassPeriod;
    if (!(speed < kSlow)) moved_at = n;
  }
  cell.rests = moved_at < steps ? kMassPeriod * moved_at : -1.0;
  return cell;
}

MassCost mass_cost(const std::string& task, const std::string& way, int steps) {
  using Clock = std::chrono::steady_clock;
  const BodyTool tool = mass_tool(way, 0.1, {}, kMassCostPoints);
  const Object plane = mass_plane(kMassContact);
  BodyMemory memory;
  std::vector<double> times;
  std::size_t evaluations = 0;
  times.reserve(static_cast<std::size_t>(steps));
  for (int n = 0; n < steps; ++n) {
    const Pose device = device_at(task, kMassPeriod * n);
    const auto start = Clock::now();
    evaluations += step_body(tool, std::span(&plane, 1), device, kMassPeriod, memory).evaluations;
    times.push_back(std::chrono::duration<double, std::nano>(Clock::now() - start).count());
  }
  std::ranges::sort(times);
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  return {task, way, at(0.5), at(0.99), static_cast<double>(evaluations) / steps};
}

}  // namespace

MassTrade run_trade_mass(const MassGrid& grid) {
  MassTrade trade;
  for (const std::string& task : kMassTasks)
    for (const std::string& way : kMassWays)
      trade.cost.push_back(mass_cost(task, way, grid.cost_steps));
  measure_accuracy(grid, trade.accuracy);
  for (const std::string& way : kMassWays)
    for (const double mass : grid.masses)
      for (const double stiffness : grid.stiffnesses)
        trade.stability.push_back(thrown_at(way, stiffness, mass, grid.throw_time));
  return trade;
}

}  // namespace feltwire
