#include "sim/studies/bound/zwidth.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.hpp"
#include "sim/measure/experiment_metrics.hpp"

namespace feltwire {
namespace {

constexpr double kZwidthPress = 3.0;  // [N] force with which the hand presses
constexpr double kDeepest = 0.03;     // [m] largest assumed compression of the wall
constexpr double kLeadIn = 0.5;       // [s] duration of the hand's approach
constexpr double kAtRest = 1.0;       // [s] time after which the hand is at rest
constexpr double kDuration = 2.0;     // [s] duration of a run

ExperimentSetup press_setup(const Method& method, double damping, double rate, double delay,
                            double stiffness, const Hand& hand, const Plant& plant) {
  ExperimentSetup setup;
  setup.hand.hand = hand;
  setup.hand.plant = for_any_hand(plant);
  setup.hand.spec = builtin_device("simulated");
  setup.hand.spec.damping = damping;
  setup.hand.task.path = HandPath::press;
  setup.hand.task.lead_in = kLeadIn;
  setup.hand.task.depth =
      kZwidthPress / setup.hand.hand.stiffness + std::min(kZwidthPress / stiffness, kDeepest);
  setup.duration = kDuration;
  setup.bounding.period = 1.0 / rate;
  setup.bounding.damping = damping;
  setup.delay = delay_samples(delay, setup.bounding.period);
  method.apply(setup.bounding);
  return setup;
}

}  // namespace

ZWidthGrid full_zwidth_grid() {
  ZWidthGrid grid;
  grid.methods.assign(methods().begin(), methods().end());
  return grid;
}

ZWidthGrid hands_zwidth_grid() {
  ZWidthGrid grid = full_zwidth_grid();
  grid.rates = {1000.0};
  grid.hands.assign(kEightHands.begin(), kEightHands.end());
  return grid;
}

double quantum_limit() {
  const DeviceSpec& spec = builtin_device("simulated");
  return 2.0 * spec.coulomb_friction / spec.position_resolution;
}

Press press_wall(const Method& method, double damping, double rate, double delay, double stiffness,
                 const Hand& hand, const Plant& plant) {
  // The wall is the half space below z = 0.
  const Environment wall = [stiffness](const Tool& tool) {
    Command command;
    command.elastic.z() = stiffness * std::max(0.0, -tool.position.z());
    return command;
  };
  const auto samples =
      run_experiment(wall, press_setup(method, damping, rate, delay, stiffness, hand, plant));

  std::vector<double> height;
  double depth = 0.0, force = 0.0;  // [m], [N] sums over the samples at rest
  for (const ExperimentSample& s : samples) {
    height.push_back(s.position.z());
    if (s.time < kAtRest) continue;
    depth -= s.position.z();
    force += s.rendered.force().z();
  }
  Press press;
  press.oscillation = highpass_rms(height, rate);
  if (press.calm() && depth > 0.0) press.displayed = force / depth;
  return press;
}

std::vector<ZWidthCell> map_zwidth(const ZWidthGrid& grid) {
  std::vector<ZWidthCell> cells;
  std::vector<const Method*> method_of;
  std::vector<Hand> hand_of;
  for (const Method& method : grid.methods)
    for (const double damping : grid.dampings)
      for (const double rate : grid.rates)
        for (const double delay : grid.delays)
          for (const NamedHand& hand : grid.hands) {
            ZWidthCell cell;
            cell.method = method.label;
            cell.hand = hand.name;
            cell.damping = damping;
            cell.rate = rate;
            cell.delay = delay;
            cell.samples = delay_samples(delay, 1.0 / rate);
            cells.push_back(cell);
            method_of.push_back(&method);
            hand_of.push_back(hand.hand);
          }
  parallel_for(cells.size(), [&](std::size_t i) {
    ZWidthCell& cell = cells[i];
    const auto press = [&](double stiffness) {
      return press_wall(*method_of[i], cell.damping, cell.rate, cell.delay, stiffness, hand_of[i],
                        grid.plant);
    };
    cell.limit = largest_calm(grid.range, [&](double k) { return press(k).calm(); });
    if (cell.limit.stiffness > 0.0) cell.at_limit = press(cell.limit.stiffness);
    cell.at_fixed = press(kFixedStiffness);
  });
  return cells;
}

}  // namespace feltwire
