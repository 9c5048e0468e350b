// The commands of feltwire-lab trade. Each command runs a study that measures the cost of a
// setting.

#include <memory>

#include "sim/lab/study_commands.hpp"
#include "sim/studies/network/trade_network.hpp"
#include "sim/studies/scene/sixdof_tasks.hpp"
#include "sim/studies/scene/trade_geometry.hpp"
#include "sim/studies/scene/trade_mass.hpp"
#include "sim/studies/scene/trade_scene.hpp"
#include "sim/studies/scene/trade_sixdof.hpp"
#include "sim/studies/scene/trade_tools.hpp"

namespace feltwire {
namespace {

std::string trade_geometry(const std::string& out) {
  const auto cells = run_trade_geometry({});
  write_trade_geometry(out, cells);
  return trade_geometry_table(cells);
}

std::string trade_tools(const std::string& out) {
  const auto cells = run_trade_tools({});
  write_trade_tools(out, cells);
  return trade_tools_table(cells);
}

std::string trade_mass(const std::string& out) {
  const auto trade = run_trade_mass({});
  write_trade_mass(out, trade);
  return trade_mass_table(trade);
}

std::string trade_scene(const std::string& out) {
  constexpr std::size_t kRounds = 101, kBareRounds = 2001;
  const auto cases = scene_cases();
  const auto cells = run_trade_scene(cases, kRounds);
  const auto bare = run_bare(kBareRounds);
  write_trade_scene(out, cells, bare);
  return trade_scene_table(cells, bare);
}

std::string trade_network(const std::string& out) {
  constexpr double kTaskTime = 4.0;  // [s] simulated time of each task
  const auto settings = traffic_settings();
  const auto cells = run_trade_network(settings, kTaskTime);
  write_trade_network(out, settings, cells);
  return trade_network_table(settings, cells) + '\n' + trade_network_cost_table(settings, cells);
}

std::string trade_sixdof(const SixDofGrid& grid, const std::string& out) {
  const auto cells = run_trade_sixdof(grid);
  write_trade_sixdof(out, cells);
  return trade_sixdof_table(cells);
}

}  // namespace

void add_trade(CLI::App& app) {
  CLI::App* trade = app.add_subcommand("trade", "Measure the cost of each setting");
  trade->require_subcommand(1);
  const auto add = [&](const std::string& name, const std::string& question,
                       const std::string& footer, const auto& run,
                       const char* files = "Tables and pictures") {
    return add_study(*trade, name, "trade-" + name, question,
                     footer + " docs/lab/trade.md explains the results.", files, run);
  };
  add("geometry", "Analytic solid, mesh or grid of distances: error, time and memory",
      "Writes trade_geometry.csv, trade_geometry.json and trade_geometry.png, which are\n"
      "deterministic. Writes the times on this machine to trade_geometry_cost.csv and\n"
      "trade_geometry_cost.png. Takes a minute of CPU time.",
      trade_geometry);
  add("tools", "Number of points on a tool's body: force error and torque error against time",
      "Writes trade_tools.csv, trade_tools.json and trade_tools.png, which are deterministic.\n"
      "Writes the times on this machine to trade_tools_cost.csv and trade_tools_cost.png. Takes a\n"
      "minute of CPU time.",
      trade_tools);
  add("mass", "Integration methods for a tool with mass: accuracy, stability and time",
      "Writes trade_mass.csv, trade_mass_stability.csv and trade_mass.png, which are\n"
      "deterministic. Writes the times on this machine to trade_mass_cost.csv. Takes some minutes\n"
      "of CPU time.",
      trade_mass);
  const auto sixdof = std::make_shared<SixDofGrid>();
  add(
      "sixdof",
      "A tool's body as points or as polygons, with and without mass: error, jumps and time",
      "Writes trade_sixdof.csv and trade_sixdof.json, which are deterministic. Writes the times\n"
      "on this machine to trade_sixdof_cost.csv. Takes some minutes on two cores.",
      [sixdof](const std::string& out) { return trade_sixdof(*sixdof, out); }, "Tables")
      ->add_option("--task", sixdof->tasks,
                   "Run only this task. Repeat the option for several tasks")
      ->check(CLI::IsMember(sixdof_task_names()));
  add("scene", "Time that each property of a scene takes for one sample",
      "Writes the times on this machine to trade_scene.csv, trade_scene_bare.csv and\n"
      "trade_scene.png. Takes half a minute of CPU time.",
      trade_scene);
  add("network", "Bandwidth against force error, direction error and delay, over three links",
      "Writes trade_network.csv, trade_network.json and trade_network.png, which are\n"
      "deterministic. Takes some minutes of CPU time.",
      trade_network);
}

}  // namespace feltwire
