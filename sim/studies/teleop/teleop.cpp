#include "sim/studies/teleop/teleop.hpp"

#include <algorithm>
#include <array>
#include <ranges>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "sim/studies/teleop/space_tasks.hpp"
#include "sim/teleoperation_laws/laws.hpp"

namespace feltwire::teleop {
namespace {

struct Network {
  double jitter, loss;  // [s], fraction of lost datagrams
};
constexpr std::array kNetworks = {Network{0.0, 0.0}, Network{5e-3, 0.0}, Network{0.0, 0.05},
                                  Network{5e-3, 0.05}, Network{20e-3, 0.3}};
constexpr std::string_view kDrift = "drift";
constexpr double kDriftTrip = 0.1;  // [s] round trip of the task `drift`

LinkOptions link_of(const TeleopCase& c) {
  constexpr double kHalf = 0.5;
  LinkOptions link;
  link.delay = kHalf * c.round_trip;
  link.jitter = c.jitter;
  link.loss = c.loss;
  link.keep_order = false;
  return link;
}

TeleopRow run_case(const TeleopCase& c) {
  if (const auto task = std::ranges::find(tasks(), c.task, &Task::name); task != tasks().end()) {
    BenchSetup setup = task->setup;
    setup.link = link_of(c);
    const auto law = make_law(c.law, setup.plant);
    return {c, judge(*task, run_bench(*law, setup), c.round_trip)};
  }
  const auto task = std::ranges::find(in_space::space_tasks(), c.task, &in_space::SpaceTask::name);
  if (task == in_space::space_tasks().end())
    throw std::invalid_argument("the bench of teleoperation has no task '" + c.task + "'");
  in_space::SpaceSetup setup = task->setup;
  setup.link = link_of(c);
  const auto law = make_spatial_law(c.law, setup.plant, [&setup](const Vec3& tip) {
    return in_space::wrong_model(setup.around, tip);
  });
  return {c, judge(*task, in_space::run_space_bench(*law, setup))};
}

}  // namespace

std::vector<std::string_view> task_names() {
  std::vector<std::string_view> names;
  for (const Task& task : tasks()) names.push_back(task.name);
  for (const in_space::SpaceTask& task : in_space::space_tasks()) names.push_back(task.name);
  return names;
}

std::vector<TeleopCase> teleop_cases(bool quick) {
  const std::vector<double> trips =
      quick ? std::vector<double>{0.0, 0.1} : std::vector<double>{0.0, 0.02, 0.05, 0.1, 0.2, 0.3};
  std::vector<TeleopCase> cases;
  for (const std::string_view law : law_names())
    for (const std::string_view task : task_names())
      for (const double trip : trips)
        for (const Network& network : kNetworks) {
          const bool bad = network.jitter > 0.0 && network.loss > 0.0;
          const bool perfect = network.jitter == 0.0 && network.loss == 0.0;
          if (quick && !perfect && !(bad && network.loss < 0.1)) continue;
          // A run of the task `drift` simulates a minute, so it has only one round trip, with
          // jitter and loss.
          if (task == kDrift && !(bad && trip == kDriftTrip)) continue;
          cases.push_back(
              {std::string(law), std::string(task), trip, network.jitter, network.loss});
        }
  return cases;
}

std::vector<TeleopRow> run_teleop(const std::vector<TeleopCase>& cases) {
  tasks();
  in_space::space_tasks();
  std::vector<TeleopRow> rows(cases.size());
  parallel_for(cases.size(), [&](std::size_t i) { rows[i] = run_case(cases[i]); });
  return rows;
}

}  // namespace feltwire::teleop
