#include "sim/studies/network/where_to_bound.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "sim/hands/amplifier_lag.hpp"
#include "sim/measure/fidelity.hpp"
#include "sim/measure/network_run.hpp"

namespace feltwire {
namespace {

constexpr double kSidesPress = 3.0;  // [N] force with which the hand presses
constexpr double kDamping = 0.5;     // device damping b [N s/m]
constexpr double kSidesBall = 0.09;  // [m] radius of the ball

struct WhereToBoundTask {
  std::string_view name;
  double stiffness;  // [N/m]
  bool ball = false, taking = false;
  HandPath path = HandPath::press;
  double duration = 3.0;  // [s]
};
const std::array<WhereToBoundTask, 5> kWhereToBoundTasks = {
    {{.name = "wall 40 kN/m", .stiffness = 4e4},
     {.name = "wall 1 kN/m", .stiffness = 1e3},
     {.name = "sphere 1 kN/m",
      .stiffness = 1e3,
      .ball = true,
      .path = HandPath::orbit,
      .duration = 6.0},
     {.name = "taps 1 kN/m", .stiffness = 1e3, .path = HandPath::taps},
     {.name = "taking hand", .stiffness = 4e4, .taking = true}}};

Scene scene_of(const WhereToBoundTask& task) {
  Object object{
      .name = "object", .shape = Plane{}, .pose = {}, .material = {.stiffness = task.stiffness}};
  if (task.ball) object.shape = Sphere{kSidesBall};
  return Scene("sides", {object});
}

double height(const WhereToBoundTask& task, const Vec3& position) {
  return task.ball ? position.norm() - kSidesBall : position.z();
}
Vec3 normal(const WhereToBoundTask& task, const Vec3& position) {
  return task.ball ? direction(position) : Vec3(Vec3::UnitZ());
}

NetworkRunOptions options_of(const WhereToBoundTask& task, const Hand& arm) {
  NetworkRunOptions options;
  options.duration = task.duration;
  options.hand.spec = builtin_device("simulated");
  options.hand.spec.damping = kDamping;
  options.hand.hand = arm;
  HandTask& hand = options.hand.task;
  hand.path = task.path;
  hand.depth = kSidesPress / options.hand.hand.stiffness;
  if (task.taking) options.taking = TakingTask{.start = {0, 0, 1e-3}, .depth = 8e-3};
  if (task.path == HandPath::press) hand.depth += kSidesPress / task.stiffness;
  if (task.path == HandPath::taps) {
    hand.frequency = 2.0;
    hand.clearance = 5e-3;
  }
  if (task.ball) go_round(hand, kSidesBall);
  return options;
}

/// Sums over the second half of a run.
struct Sums {
  double height = 0.0;                            // [m]
  double force_depth = 0.0, depth_squared = 0.0;  // [N m], [m^2]
};

void measure(const WhereToBoundTask& task, const NetworkRunResult& run, bool ideal,
             WhereToBoundCell& cell) {
  std::vector<double> heights;
  Sums sums;
  const std::size_t half = run.samples.size() / 2;
  for (std::size_t n = 0; n < run.samples.size(); ++n) {
    const NetworkSample& s = run.samples[n];
    heights.push_back(height(task, s.position));
    if (n < half) continue;
    const double depth = std::max(0.0, -heights.back());
    sums.height += heights.back();
    sums.force_depth += s.held.force().dot(normal(task, s.position)) * depth;
    sums.depth_squared += depth * depth;
  }
  const auto ratio = [](double a, double b) { return b > 0.0 ? a / b : 0.0; };
  cell.oscillation = highpass_rms(heights, 1.0 / SessionParameters{}.servo_period);
  const double mean = sums.height / static_cast<double>(heights.size() - half);
  double squares = 0.0;
  for (std::size_t n = half; n < heights.size(); ++n)
    squares += (heights[n] - mean) * (heights[n] - mean);
  if (task.path != HandPath::taps && !task.taking)
    cell.sway = std::sqrt(squares / static_cast<double>(heights.size() - half));
  cell.displayed = ratio(sums.force_depth, sums.depth_squared);
  const Fidelity felt = fidelity(std::span(run.samples).subspan(half));
  cell.force_ratio = felt.ratio();
  cell.force_error = felt.relative_error();
  cell.direction_mean = felt.direction.mean;
  cell.direction_p99 = felt.direction.p99;
  cell.margin = run.measured_port.least_margin();
  cell.true_margin = run.true_port.least_margin();
  cell.device_margin = ideal ? run.least_device_margin : -run.true_energy.made;
  cell.violations = run.measured_port.violations();
  cell.answered = ratio(static_cast<double>(run.servo.replies.answered),
                        static_cast<double>(run.servo.samples));
}

void run_where_to_bound_cell(const WhereToBoundTask& task, const Hand& hand,
                             const WhereToBoundGrid& grid, WhereToBoundCell& cell) {
  NetworkRunOptions options = options_of(task, hand);
  options.hand.plant = for_any_hand(grid.plant);
  if (grid.assumed_damping != 1.0 || grid.told) {
    options.told = options.hand.spec;
    options.told->damping = grid.assumed_damping * kDamping;
  }
  if (grid.told) {
    const MotorLag lag = lag_of(grid.plant.amplifier);
    options.told->actuation.lag = lag.time;
    options.told->actuation.kind = lag.kind;
  }
  if (cell.bound == kSidesBounds[0]) {
    options.parameters.mode = kUnbounded;
  } else {
    options.parameters.side = bounding_side(cell.bound);
  }
  for (LinkOptions* way : {&options.link.up, &options.link.down}) {
    way->delay = 0.5 * cell.round_trip;
    way->jitter = cell.jitter;
    way->loss = cell.loss.loss;
    way->burst = cell.loss.burst;
  }
  measure(task, run_network(scene_of(task), options), grid.plant.ideal(), cell);
}

}  // namespace

WhereToBoundGrid hands_where_to_bound_grid() {
  WhereToBoundGrid grid;
  grid.jitters = {0.0};
  grid.losses = {{0.0, 0.0}, {0.1, 0.0}};
  grid.hands.assign(kEightHands.begin(), kEightHands.end());
  grid.adversarial_hand = false;
  return grid;
}

std::vector<WhereToBoundCell> run_where_to_bound(const WhereToBoundGrid& grid) {
  if (!(grid.assumed_damping > 0.0) || !std::isfinite(grid.assumed_damping))
    throw std::invalid_argument(
        "the assumed damping must be finite and above zero, 1 is the truth");
  std::vector<WhereToBoundCell> cells;
  const std::size_t tasks = kWhereToBoundTasks.size() - (grid.adversarial_hand ? 0 : 1);
  for (const WhereToBoundTask& task : std::span(kWhereToBoundTasks).first(tasks))
    for (const std::string_view bound : kSidesBounds)
      for (const double round_trip : grid.round_trips)
        for (const double jitter : grid.jitters)
          for (const SidesLoss& loss : grid.losses)
            for (const NamedHand& hand : grid.hands) {
              WhereToBoundCell cell;
              cell.task = task.name;
              cell.bound = bound;
              cell.hand = hand.name;
              cell.round_trip = round_trip;
              cell.jitter = jitter;
              cell.loss = loss;
              cells.push_back(cell);
            }
  const std::size_t per_task = cells.size() / tasks;
  parallel_for(cells.size(), [&](std::size_t i) {
    run_where_to_bound_cell(kWhereToBoundTasks[i / per_task],
                            grid.hands[i % grid.hands.size()].hand, grid, cells[i]);
  });
  return cells;
}

bool bounds_hold(const std::vector<WhereToBoundCell>& cells) {
  return std::all_of(cells.begin(), cells.end(), [](const WhereToBoundCell& cell) {
    return cell.bound == kSidesBounds[0] ||
           (cell.violations == 0 && cell.device_margin >= -kWhereToBoundRounding);
  });
}

}  // namespace feltwire
