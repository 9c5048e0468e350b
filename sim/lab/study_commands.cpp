// The commands of feltwire-lab that run studies. Most studies write their results to a folder.

#include "sim/lab/study_commands.hpp"

#include <filesystem>
#include <iostream>
#include <memory>

#include "client/hands/plant_file.hpp"
#include "core/base/visible_text.hpp"
#include "sim/studies/bound/figures.hpp"
#include "sim/studies/bound/frontier.hpp"
#include "sim/studies/bound/frontier_judged.hpp"
#include "sim/studies/bound/rate.hpp"
#include "sim/studies/bound/torque_figures.hpp"
#include "sim/studies/bound/zwidth.hpp"
#include "sim/studies/fleet/fleet_scenarios.hpp"
#include "sim/studies/network/deadband_study.hpp"
#include "sim/studies/network/local_model_study.hpp"
#include "sim/studies/network/where_to_bound.hpp"
#include "sim/studies/teleop/arm_bench.hpp"
#include "sim/studies/teleop/teleop.hpp"

namespace feltwire {

std::string placed(const std::string& what, const std::string& out) {
  return "\n" + what + " are in " +
         visible(std::filesystem::absolute(out).lexically_normal().string()) + "\n";
}

void add_out(CLI::App& command, std::string& out) {
  command.add_option("--out", out, "Folder for the results. It is created if it is missing")
      ->capture_default_str();
}

CLI::App* add_study(CLI::App& app, const std::string& name, const std::string& folder,
                    const std::string& question, const std::string& footer,
                    const std::string& files,
                    const std::function<std::string(const std::string& out)>& run) {
  auto out = std::make_shared<std::string>(folder);
  CLI::App* study = app.add_subcommand(name, question);
  study->footer(footer);
  add_out(*study, *out);
  study->callback([out, files, run] { std::cout << run(*out) << placed(files, *out); });
  return study;
}

namespace {

void add_figures(CLI::App& app) {
  add_study(
      app, "figures", "figures",
      "Reproduce the paper's Figures 2, 3, 5 and 6, and Figures 5 and 6 with torque",
      "Writes figures.json, one CSV per run, and PNG pictures with their gnuplot scripts. A CSV\n"
      "has t [s], x,y,z [m], the commanded elastic force ex..ez and frictional force fx..fz [N on\n"
      "the hand], the rendered force rx..rz [N on the hand] and the energy flow-in energy_x..z\n"
      "[J]. Writes the same for torque (docs/lab/torque.md). The numbers are deterministic.",
      "Pictures, data, figures.json and torque_figures.json", [](const std::string& out) {
        const std::string forces = figures_table(write_figures(out));
        return forces + torque_figures_table(write_torque_figures(out));
      });
}

void add_plant(CLI::App& command, std::string& plant) {
  command.add_option("--plant", plant,
                     "FILE.json with the motor lag, the transmission and more (docs/devices.md)");
}

/// The plant of a study, and whether the bounds know its lag.
struct StudiedPlant {
  std::string file;
  bool told = false;

  bool given() const { return !file.empty(); }
  /// The plant of the file; an ideal one if none is given.
  Plant load() const { return given() ? load_plant(file) : Plant{}; }
  template <class Grid>
  Grid in(Grid grid) const {
    grid.plant = load();
    grid.told = told;
    return grid;
  }
  /// Runs the part of a study that has an ideal device, and returns its table. With a plant it only
  /// creates the folder for the rest.
  template <class Ideal>
  std::string unless_given(const std::string& out, const Ideal& ideal) const {
    if (!given()) return ideal();
    std::filesystem::create_directories(out);
    return {};
  }
};

void add_studied_plant(CLI::App& command, StudiedPlant& plant) {
  add_plant(command, plant.file);
  command.add_flag("--told", plant.told, "The bounds use the motor lag of the plant")
      ->needs(command.get_option("--plant"));
}

void add_zwidth(CLI::App& app) {
  struct Options {
    std::string out = "zwidth";
    StudiedPlant plant;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "zwidth", "Map the stiffest wall without oscillation, by method, device and control loop");
  command->footer(
      "A simulated hand presses a wall with 3 N, by method x device damping x servo rate x delay.\n"
      "Writes zwidth.json, zwidth.csv, zwidth_hands.csv (eight hands at 1 kHz) and a picture per\n"
      "damping (zwidth_bB.png). The results are deterministic and take some minutes on two cores.\n"
      "docs/lab/laboratory.md explains them.\n"
      "With --plant: writes only zwidth_hands.csv, for eight hands without delay on this plant.");
  add_out(*command, o->out);
  add_plant(*command, o->plant.file);
  command->callback([o] {
    ZWidthGrid by_hands = hands_zwidth_grid();
    by_hands.plant = o->plant.load();
    if (o->plant.given()) by_hands.delays = {0.0};
    const std::string table = o->plant.unless_given(o->out, [&] {
      const ZWidthGrid grid = full_zwidth_grid();
      return zwidth_table(write_zwidth(o->out, grid), grid);
    });
    const auto cells = map_zwidth(by_hands);
    write_zwidth_hands(o->out, cells);
    std::cout << table << zwidth_hands_table(cells)
              << placed(o->plant.given() ? "Table" : "Map and pictures", o->out);
  });
}

void add_frontier(CLI::App& app) {
  struct Options {
    std::string out = "frontier", plant;
    bool told = false, judged = false;
    int hands = 40;
    std::uint64_t seed = 40'261'130;  // no threshold was chosen with it
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "frontier",
      "Map the stiffness that each law displays on real devices, by the knowledge about the hand");
  command->footer(
      "Eight hands touch walls, a corner, an edge, a sphere, a torus and friction, and tap, by\n"
      "law x device damping x wall x delay. Laws of other papers run on some of these cases.\n"
      "Writes frontier.json, frontier.csv and three pictures. All results but the cost are\n"
      "deterministic and take some minutes on two cores. docs/lab/frontier.md explains them.\n"
      "With --plant: runs first presses and taps of the same hands on devices with this plant,\n"
      "without pictures. The method shaped runs as a whole session.\n"
      "With --judged: prints the bars of a device like a PHANToM Premium whose lag is told, on\n"
      "hands and plants that are drawn.");
  add_out(*command, o->out);
  add_plant(*command, o->plant);
  command->add_flag("--told", o->told,
                    "With --plant: laws and energy accounts use the motor lag of the plant");
  CLI::Option* judged = command->add_flag(
      "--judged", o->judged, "Print the bars of a real device on drawn hands and plants");
  for (const char* option : {"--plant", "--told"}) judged->excludes(command->get_option(option));
  command->add_option("--hands", o->hands, "Number of drawn hands")
      ->needs(judged)
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  command->add_option("--seed", o->seed, "Seed of the hands and plants")
      ->needs(judged)
      ->capture_default_str();
  command->callback([o] {
    if (o->judged) {
      std::cout << judged_table(o->seed, o->hands);
      return;
    }
    if (!o->plant.empty()) {
      const auto rows = run_frontier(plant_cases(load_plant(o->plant), o->told));
      write_rows(o->out, rows);
      std::cout << plant_table(rows) << placed("Tables", o->out);
      return;
    }
    const auto rows = write_frontier(o->out, frontier_cases());
    std::cout << frontier_table(rows) << sessions_table(rows) << published_table(rows)
              << learning_table(run_frontier(learning_cases()))
              << placed("Table and pictures", o->out);
  });
}

void add_rate(CLI::App& app) {
  struct Options {
    std::string out = "rate";
    StudiedPlant plant;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("rate", "Compare speed and accuracy, by servo rate and number type");
  command->footer(
      "Writes rate.csv, rate.json, rate.png and rate_hands.csv (eight hands), which are\n"
      "deterministic. Writes the times on this machine to rate_cost.csv and rate_cost.png.\n"
      "docs/lab/trade.md explains the results.\n"
      "With --plant: writes only rate_hands.csv, for eight hands on this plant.");
  add_out(*command, o->out);
  add_studied_plant(*command, o->plant);
  command->callback([o] {
    const std::string table = o->plant.unless_given(o->out, [&] {
      const RateGrid grid;
      const auto cells = run_rate(grid);
      const auto costs = measure_rate_cost();
      write_rate(o->out, grid, cells, costs);
      return rate_table(cells) + '\n' + rate_cost_table(grid, costs);
    });
    const auto by_hands = run_rate(o->plant.in(hands_rate_grid()));
    write_rate_hands(o->out, by_hands);
    std::cout << table << rate_hands_table(by_hands)
              << placed(o->plant.given() ? "Tables" : "Tables and pictures", o->out);
  });
}

void add_where_to_bound(CLI::App& app, int& status) {
  struct Options {
    std::string out = "sides";
    WhereToBoundGrid grid;
    StudiedPlant plant;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "where-to-bound",
      "Compare bounds at the server, the client or both, over delay, jitter and loss");
  command->footer(
      "Runs whole sessions in virtual time. Writes sides.csv, sides.json, sides.png and\n"
      "sides_hands.csv (eight hands). The results are deterministic and take a minute of CPU\n"
      "time. Exit status 1: a bounded port delivered more energy than the device dissipated.\n"
      "docs/network.md explains the results.\n"
      "With --plant: writes only sides_hands.csv, for eight hands on this plant. The energy is\n"
      "then that of the true motor.");
  add_out(*command, o->out);
  add_studied_plant(*command, o->plant);
  command
      ->add_option("--assumed-damping", o->grid.assumed_damping,
                   "Damping that the bounds assume, divided by the real damping. Above 1 the study "
                   "must fail")
      ->capture_default_str();
  command->callback([o, &status] {
    bool hold = true;
    const std::string table = o->plant.unless_given(o->out, [&] {
      const auto cells = run_where_to_bound(o->grid);
      write_where_to_bound(o->out, cells);
      hold = bounds_hold(cells);
      return where_to_bound_table(cells);
    });
    WhereToBoundGrid hands = o->plant.in(hands_where_to_bound_grid());
    hands.assumed_damping = o->grid.assumed_damping;
    const auto by_hands = run_where_to_bound(hands);
    write_where_to_bound_hands(o->out, by_hands);
    std::cout << table << where_to_bound_hands_table(by_hands)
              << placed(o->plant.given() ? "Tables" : "Tables and picture", o->out);
    status = hold && bounds_hold(by_hands) ? 0 : 1;
  });
}

void add_deadband(CLI::App& app) {
  struct Options {
    std::string out = "deadband", recording, side = std::string(name(SessionParameters{}.side)),
                link = "delay=0";
    DeadbandGrid grid;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "deadband", "Measure the datagrams that a perceptual deadband saves, and its force error");
  command->footer(
      "Runs simulated hands in whole sessions in virtual time, by deadband and fraction. Writes\n"
      "deadband.csv, deadband.json and deadband.png, which are deterministic. docs/network.md\n"
      "explains the results.");
  add_out(*command, o->out);
  command->add_option("--recording", o->recording,
                      "FILE.csv (t,x,y,z) of a further movement, over a plane at z = 0");
  command->add_option("--bounding", o->side, "Place of the bound: server, client or both")
      ->capture_default_str();
  command
      ->add_option("--link", o->link, "Emulated network between client and server (docs/link.md)")
      ->capture_default_str();
  command
      ->add_option("--keep-alive", o->grid.parameters.keep_alive,
                   "[s] Longest time without a datagram")
      ->capture_default_str();
  command
      ->add_option("--hold-time", o->grid.parameters.hold_time,
                   "[s] Age at which a command has faded to zero")
      ->capture_default_str();
  command->callback([o] {
    DeadbandGrid& grid = o->grid;
    grid.parameters.side = bounding_side(o->side);
    grid.link = parse_link(o->link);
    std::optional<Recording> recording;
    if (!o->recording.empty()) recording = read_recording(o->recording, "give a CSV with t,x,y,z");
    const auto rows = run_deadband(deadband_tasks(recording), grid);
    write_deadband(o->out, grid, rows);
    std::cout << deadband_table(rows) << placed("Table and picture", o->out);
  });
}

void add_local_model(CLI::App& app) {
  add_study(
      app, "local-model", "local_model",
      "Compare a local contact model with replies of forces alone, by round-trip time and rate",
      "Writes local_model.csv, local_model.json and local_model.png, which are deterministic.\n"
      "docs/network.md explains the results.",
      "Table and picture", [](const std::string& out) {
        const auto cells = run_local_model();
        write_local_model(out, cells);
        return local_model_table(cells);
      });
}

void add_fleet(CLI::App& app) {
  add_study(
      app, "fleet", "fleet",
      "Simulate a fleet of hosts: lost racks, a lost directory, a partition, restarts",
      "Runs 10,000 scenes with a million hands in virtual time. Writes fleet.json, which is\n"
      "deterministic. docs/fleet.md explains the results and names the source of each number.",
      "The numbers", [](const std::string& out) {
        const fleet::FleetStudy study = fleet::run_fleet({});
        fleet::write_fleet(out, study);
        return fleet::fleet_table(study);
      });
}

void add_teleop(CLI::App& app) {
  struct Options {
    std::string out = "teleop";
    bool quick = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "teleop",
      "Compare laws of bilateral teleoperation on one bench, over delay, jitter and loss");
  command->footer(
      "A hand moves a robot in its environment, in one degree of freedom and virtual time.\n"
      "Feltwire's own law also runs with a simulated arm in three degrees of freedom. Writes\n"
      "teleop.json, teleop.csv, teleop.png and arm.json, the same bytes every time.\n"
      "docs/teleoperation.md explains the results.");
  add_out(*command, o->out);
  command->add_flag("--quick", o->quick, "Run only two round-trip times and two links");
  command->callback([o] {
    const auto rows = teleop::run_teleop(teleop::teleop_cases(o->quick));
    teleop::write_teleop(o->out, rows);
    const auto arm = teleop::with_arm::run_arm(teleop::with_arm::arm_cases(o->quick));
    teleop::with_arm::write_arm(o->out, arm);
    std::cout << teleop::teleop_table(rows) << teleop::with_arm::arm_table(arm)
              << placed("Tables and picture", o->out);
  });
}

}  // namespace

void add_studies(CLI::App& app, int& status) {
  add_figures(app);
  add_zwidth(app);
  add_frontier(app);
  add_advise(app);
  add_torque(app, status);
  add_convex_parts(app);
  add_compare(app);
  add_extremes(app, status);
  add_rate(app);
  add_where_to_bound(app, status);
  add_deadband(app);
  add_local_model(app);
  add_fleet(app);
  add_teleop(app);
  add_trade(app);
}

}  // namespace feltwire
