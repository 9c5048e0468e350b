#include "sim/studies/teleop/teleop.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "sim/teleoperation_laws/laws.hpp"

namespace feltwire::teleop {
namespace {

struct Network {
  double jitter, loss;  // [s], share
};
constexpr std::array kNetworks = {Network{0.0, 0.0}, Network{5e-3, 0.0}, Network{0.0, 0.05},
                                  Network{5e-3, 0.05}, Network{20e-3, 0.3}};
constexpr double kDriftTrip = 0.1;  // [s]

const Task& task_of(const std::string& name) {
  const auto found = std::ranges::find(tasks(), name, &Task::name);
  if (found == tasks().end())
    throw std::invalid_argument("the bench of teleoperation has no task '" + name + "'");
  return *found;
}

TeleopRow run_case(const TeleopCase& c) {
  const Task& task = task_of(c.task);
  BenchSetup setup = task.setup;
  constexpr double kHalf = 0.5;
  setup.link.delay = kHalf * c.round_trip;
  setup.link.jitter = c.jitter;
  setup.link.loss = c.loss;
  setup.link.keep_order = false;
  const auto law = make_law(c.law, setup.plant);
  return {c, judge(task, run_bench(*law, setup), c.round_trip)};
}

}  // namespace

std::vector<TeleopCase> teleop_cases(bool quick) {
  const std::vector<double> trips =
      quick ? std::vector<double>{0.0, 0.1} : std::vector<double>{0.0, 0.02, 0.05, 0.1, 0.2, 0.3};
  std::vector<TeleopCase> cases;
  for (const std::string_view law : law_names())
    for (const Task& task : tasks())
      for (const double trip : trips)
        for (const Network& network : kNetworks) {
          const bool bad = network.jitter > 0.0 && network.loss > 0.0;
          const bool perfect = network.jitter == 0.0 && network.loss == 0.0;
          if (quick && !perfect && !(bad && network.loss < 0.1)) continue;
          // A minute long: where drift can come from, and no more.
          if (task.judge == Task::Judge::drift && !(bad && trip == kDriftTrip)) continue;
          cases.push_back(
              {std::string(law), std::string(task.name), trip, network.jitter, network.loss});
        }
  return cases;
}

std::vector<TeleopRow> run_teleop(const std::vector<TeleopCase>& cases) {
  tasks();
  std::vector<TeleopRow> rows(cases.size());
  parallel_for(cases.size(), [&](std::size_t i) { rows[i] = run_case(cases[i]); });
  return rows;
}

}  // namespace feltwire::teleop
