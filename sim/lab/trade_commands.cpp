// The trade studies of feltwire-lab. Each measures the cost of a setting.

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
  constexpr double kTaskTime = 4.0;  // [s]
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
  CLI::App* trade = app.add_subcommand("trade", "Measure the costs of each setting");
  trade->require_subcommand(1);
  const auto add = [&](const std::string& name, const std::string& question,
                       const std::string& footer, const auto& run,
                       const char* files = "Tables and pictures") {
    return add_study(*trade, name, "trade-" + name, question,
                     footer + " docs/lab/trade.md is its page.", files, run);
  };
  add("geometry", "Analytic solid, mesh or grid of distances: error, time and memory",
      "Writes trade_geometry.csv, trade_geometry.json and trade_geometry.png, the same bytes every "
      "time, and what\nthis machine took for it, trade_geometry_cost.csv and "
      "trade_geometry_cost.png. A minute of CPU time.\n",
      trade_geometry);
  add("tools", "Number of points on a tool's body: force and torque error against time",
      "Writes trade_tools.csv, trade_tools.json and trade_tools.png, the same bytes every time, "
      "and what this machine\ntook for it, trade_tools_cost.csv and trade_tools_cost.png. A minute "
      "of CPU time.",
      trade_tools);
  add("mass", "A tool with mass: accuracy, stability and time by integration",
      "Writes trade_mass.csv, trade_mass_stability.csv and trade_mass.png, the same bytes every "
      "time, and what this\nmachine took for it, trade_mass_cost.csv. Some minutes of CPU time.",
      trade_mass);
  const auto sixdof = std::make_shared<SixDofGrid>();
  add(
      "sixdof", "A body by points or by polygons, without and with mass: error, jumps, time",
      "Writes trade_sixdof.csv and trade_sixdof.json, the same bytes every time, and what this "
      "machine took for it,\ntrade_sixdof_cost.csv. Some minutes on two cores.",
      [sixdof](const std::string& out) { return trade_sixdof(*sixdof, out); }, "Tables")
      ->add_option("--task", sixdof->tasks, "Only this task; may be given several times")
      ->check(CLI::IsMember(sixdof_task_names()));
  add("scene", "Time of each property of a scene for one sample, alone",
      "Writes trade_scene.csv, trade_scene_bare.csv and trade_scene.png, what this machine took. "
      "Half a minute of CPU\ntime.",
      trade_scene);
  add("network", "Bandwidth against force error, direction error and delay, over three links",
      "Writes trade_network.csv, trade_network.json and trade_network.png, the same bytes every "
      "time.\nSome minutes of CPU time.",
      trade_network);
}

}  // namespace feltwire
