#include "sim/studies/scene/trade_sixdof.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/base/parallel.hpp"
#include "sim/measure/cost.hpp"
#include "sim/studies/scene/mujoco_tool.hpp"
#include "sim/studies/scene/sixdof_tool.hpp"

namespace feltwire {
namespace {

constexpr std::array<SixDofMethod, 5> kMethods = {
    {{false, false}, {true, false}, {false, true}, {true, true}, {true, true, true}}};

/// The time resolution of a run.
struct Fineness {
  int steps = 1;         // number of integration steps per sample
  std::size_t most = 0;  // largest number of extra iterations per step, if there is no mass
};

int samples_of(const SixDofTask& task, const SixDofGrid& grid) {
  return static_cast<int>(std::lround(task.time * grid.slower / kSixDofPeriod));
}

/// Returns the force [N] and the torque [N m] on the hand at each sample.
std::vector<Vec6> felt(const SixDofTool& tool, const SixDofTask& task, int samples,
                       const Fineness& fineness) {
  const double h = kSixDofPeriod / fineness.steps;
  BodyMemory memory;
  std::vector<Vec6> wrenches;
  tool.step(task.device(0.0), h, memory);
  for (int n = 0; n < samples; ++n) {
    BodyStep now;
    for (int k = 1; k <= fineness.steps; ++k) {
      const Pose device = task.device((n + static_cast<double>(k) / fineness.steps) / samples);
      now = tool.step(device, h, memory);
      for (std::size_t i = 0; i < fineness.most && now.evaluations > 0; ++i)
        now = tool.step(device, 0.0, memory);
    }
    Vec6& wrench = wrenches.emplace_back();
    wrench << now.command.force(), now.command.torque;
  }
  return wrenches;
}

/// Returns the RMS errors of the force and of the torque, relative to the RMS of the reference
/// force. The torque is divided by the `radius` of the tool.
std::pair<double, double> errors(const std::vector<Vec6>& felt, const std::vector<Vec6>& reference,
                                 double radius) {
  double force = 0.0, torque = 0.0, whole = 0.0;
  for (std::size_t n = 0; n < felt.size(); ++n) {
    const Vec6 off = felt[n] - reference[n];
    force += off.head<3>().squaredNorm();
    torque += off.tail<3>().squaredNorm();
    whole += reference[n].head<3>().squaredNorm();
  }
  return {std::sqrt(force / whole), std::sqrt(torque / whole) / radius};
}

double largest_jump(const std::vector<Vec6>& wrenches) {
  double jump = 0.0;
  for (std::size_t n = 1; n < wrenches.size(); ++n)
    jump = std::max(jump, (wrenches[n] - wrenches[n - 1]).head<3>().norm());
  return jump;
}

/// Returns the forces and torques of the same method with a finer resolution. A tool without mass
/// is in balance at every sample, so finer steps hardly change its result. Its reference has more
/// points instead.
std::vector<Vec6> reference(const SixDofTask& task, SixDofMethod method, const SixDofGrid& grid,
                            int finer) {
  constexpr std::size_t kRepeats = 50;
  const int points = method.mass ? finer : 2 * finer;
  const SixDofTool tool = sixdof_tool(task, method, grid.points * static_cast<std::size_t>(points),
                                      grid.grid_steps * std::sqrt(static_cast<double>(points)));
  const Fineness fineness =
      method.mass ? Fineness{finer, 0} : Fineness{std::max(1, finer / 4), kRepeats};
  return felt(tool, task, samples_of(task, grid), fineness);
}

/// Returns true if a device that presses the tool along a line comes to rest. In the last third of
/// the time, the device must be slow, or its energy at most half of its energy in the second third.
/// A device that bounces steadily is not at rest.
bool is_calm(const SixDofTool& tool, const SixDofTask& task, double time) {
  constexpr double kDeviceMass = 0.05, kDamping = 2.0, kPush = 0.25;  // [kg], [N s/m], [N]
  // [m/s] A slower device is at rest. [m] A device at a larger distance has left the tool.
  constexpr double kSlow = 1e-3, kFar = 0.1;
  constexpr double kFades = 0.5;
  constexpr int kFiner = 20;  // number of steps of the device per step of the tool
  const Pose begin = task.device(0.0);
  Pose device = begin;
  double velocity = 0.0;  // [m/s] of the device along the line
  BodyMemory memory;
  const int steps = static_cast<int>(std::lround(time / kSixDofPeriod)), third = steps / 3;
  std::array<double, 3> squares{};
  for (int n = 0; n < 3 * third; ++n) {
    const double force =
        kPush + task.press.dot(tool.step(device, kSixDofPeriod, memory).command.force());
    for (int k = 0; k < kFiner; ++k) {
      constexpr double h = kSixDofPeriod / kFiner;
      velocity = (velocity + h / kDeviceMass * force) / (1.0 + h * kDamping / kDeviceMass);
      device.position += h * velocity * task.press;
    }
    if (!((device.position - begin.position).norm() < kFar)) return false;
    squares[static_cast<std::size_t>(n / third)] += velocity * velocity / third;
  }
  return squares[2] < kSlow * kSlow || squares[2] < kFades * squares[1];
}

void measure_felt(const std::vector<Vec6>& own, const std::vector<Vec6>& fine, double radius,
                  SixDofCell& cell) {
  std::tie(cell.force_error, cell.torque_error) = errors(own, fine, radius);
  cell.jump = largest_jump(own);
  cell.reference_jump = largest_jump(fine);
  for (const Vec6& wrench : own)
    cell.largest_force = std::max(cell.largest_force, wrench.head<3>().norm());
}

void measure_felt(const SixDofTool& tool, const SixDofTask& task, SixDofMethod method,
                  const SixDofGrid& grid, SixDofCell& cell) {
  const std::vector<Vec6> fine = reference(task, method, grid, grid.finer);
  measure_felt(felt(tool, task, samples_of(task, grid), {}), fine, tool.tool.radius(), cell);
  std::tie(cell.reference_force_error, cell.reference_torque_error) =
      errors(reference(task, method, grid, grid.finer / 2), fine, tool.tool.radius());
  cell.stable = largest_calm(grid.stiffness, [&](double stiffness) {
    return is_calm(stiffer(tool, stiffness), task, grid.hand_time);
  });
}

/// Measures the time of `step(device)` in several laps of a task. Calls `begin()` before each lap.
template <class Begin, class StepTo>
void measure_times(const SixDofTask& task, const SixDofGrid& grid, const Begin& begin,
                   const StepTo& step, SixDofCell& cell) {
  const int samples = samples_of(task, grid);
  std::vector<double> times;
  for (std::size_t lap = 0; lap < grid.cost_laps; ++lap) {
    begin();
    for (int n = 0; n <= samples; ++n) {
      const Pose device = task.device(static_cast<double>(n) / samples);
      const double start = cpu_seconds();
      step(device);
      times.push_back(1e9 * (cpu_seconds() - start));
    }
  }
  std::ranges::sort(times);
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  cell.median_ns = at(0.5);
  cell.p99_9_ns = at(0.999);
}

void measure_cost(const SixDofTool& tool, const SixDofTask& task, const SixDofGrid& grid,
                  SixDofCell& cell) {
  BodyMemory memory;
  measure_times(
      task, grid, [&] { memory = {}; },
      [&](const Pose& device) { tool.step(device, kSixDofPeriod, memory); }, cell);
  cell.bytes = contact_bytes(tool);
}

SixDofCell measure_mujoco(const SixDofTask& task, const SixDofGrid& grid) {
  constexpr SixDofMethod kImplicit{.polygons = true, .mass = true};
  const SixDofTool tool = sixdof_tool(task, kImplicit, grid.points, grid.grid_steps);
  MujocoTool mujoco(task, tool);
  SixDofCell cell;
  cell.task = task.name;
  cell.contact = "mujoco";
  cell.mass = "euler";
  measure_times(
      task, grid, [&] { mujoco.place(task.device(0.0)); },
      [&](const Pose& device) { mujoco.step(device); }, cell);
  cell.bytes = mujoco.bytes();
  const int samples = samples_of(task, grid);
  mujoco.place(task.device(0.0));
  std::vector<Vec6> own;
  for (int n = 1; n <= samples; ++n)
    own.push_back(mujoco.step(task.device(static_cast<double>(n) / samples)));
  measure_felt(own, reference(task, kImplicit, grid, grid.finer), tool.tool.radius(), cell);
  return cell;
}

/// Returns `cells` with a row for MuJoCo after the rows of each task.
std::vector<SixDofCell> with_mujoco(const std::vector<SixDofTask>& tasks, const SixDofGrid& grid,
                                    const std::vector<SixDofCell>& cells) {
  std::vector<SixDofCell> all;
  for (const SixDofTask& task : tasks) {
    for (const SixDofCell& cell : cells)
      if (cell.task == task.name) all.push_back(cell);
    all.push_back(measure_mujoco(task, grid));
  }
  return all;
}

}  // namespace

std::vector<SixDofCell> run_trade_sixdof(const SixDofGrid& grid) {
  const std::vector<SixDofTask> tasks =
      sixdof_tasks(grid.bunny_tolerance, grid.fine_triangles, grid.tasks);
  std::vector<SixDofCell> cells(tasks.size() * kMethods.size());
  std::vector<SixDofTool> tools;
  tools.reserve(cells.size());
  // Measure the times first, while no other work runs.
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const SixDofTask& task = tasks[i / kMethods.size()];
    const SixDofMethod method = kMethods[i % kMethods.size()];
    tools.push_back(sixdof_tool(task, method, grid.points, grid.grid_steps));
    measure_cost(tools[i], task, grid, cells[i]);
    cells[i].task = task.name;
    cells[i].contact = method.polygons ? "polygons" : "points";
    cells[i].mass = !method.mass ? "none" : method.midpoint ? "midpoint" : "implicit";
  }
  // Begin with the last tasks, because they take longest.
  parallel_for(cells.size(), [&](std::size_t n) {
    const std::size_t i = cells.size() - 1 - n;
    measure_felt(tools[i], tasks[i / kMethods.size()], kMethods[i % kMethods.size()], grid,
                 cells[i]);
  });
  return with_mujoco(tasks, grid, cells);
}

}  // namespace feltwire
