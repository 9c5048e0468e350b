// The studies of feltwire-lab. Each runs in process and writes a folder.

#include "sim/lab/study_commands.hpp"

#include <filesystem>
#include <iostream>
#include <memory>

#include "client/devices/plant_file.hpp"
#include "core/base/visible_text.hpp"
#include "core/device/device_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "sim/studies/bound/compare.hpp"
#include "sim/studies/bound/contact_frame_options.hpp"
#include "sim/studies/bound/extremes.hpp"
#include "sim/studies/bound/figures.hpp"
#include "sim/studies/bound/frontier.hpp"
#include "sim/studies/bound/rate.hpp"
#include "sim/studies/bound/torque_figures.hpp"
#include "sim/studies/bound/zwidth.hpp"
#include "sim/studies/network/deadband_study.hpp"
#include "sim/studies/network/local_model_study.hpp"
#include "sim/studies/network/methods_over_link.hpp"
#include "sim/studies/network/where_to_bound.hpp"
#include "sim/studies/teleop/arm_bench.hpp"
#include "sim/studies/teleop/teleop.hpp"

namespace feltwire {

std::string placed(const std::string& what, const std::string& out) {
  return "\n" + what + " are in " +
         visible(std::filesystem::absolute(out).lexically_normal().string()) + "\n";
}

void add_out(CLI::App& command, std::string& out) {
  command.add_option("--out", out, "Folder to write to; created when missing")
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
      "Reproduce the paper's Figures 2, 3, 5 and 6, and 5 and 6 of torque",
      "Writes figures.json, one CSV a run (t [s], x,y,z [m], ex..ez and fx..fz commanded elastic "
      "and frictional,\n"
      "rx..rz rendered [N on the hand], energy_x..z flow-in [J]) and PNG pictures with the gnuplot "
      "scripts that drew\n"
      "them; and the same of torque (docs/lab/torque.md). In process and deterministic: the same "
      "build writes the same\nnumbers.",
      "Pictures, data, figures.json and torque_figures.json", [](const std::string& out) {
        const std::string forces = figures_table(write_figures(out));
        return forces + torque_figures_table(write_torque_figures(out));
      });
}

void add_contact_frame_options(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "contact-frame-options", "Compare the options of the contact frame: projection, storage");
  command->footer("Joint or cone, minimal or elastic: the tables of docs/bounding.md.");
  command->callback([] { std::cout << contact_frame_options_tables(); });
}

void add_plant(CLI::App& command, std::string& plant) {
  command.add_option("--plant", plant,
                     "FILE.json with the lag of the motors, their transmission and more "
                     "(docs/devices.md)");
}

void add_zwidth(CLI::App& app) {
  struct Options {
    std::string out = "zwidth", plant;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "zwidth", "Map the stiffest wall without oscillation, by method, device and loop");
  command->footer(
      "A simulated hand presses a wall with 3 N, by method x device damping x servo rate x delay.\n"
      "Writes zwidth.json, zwidth.csv, zwidth_hands.csv (eight hands at 1 kHz) and a picture a "
      "damping (zwidth_bB.png).\nSome minutes on two cores; deterministic. docs/lab/laboratory.md "
      "says how to read it.\n"
      "With --plant: zwidth_hands.csv alone, of the eight hands without delay on devices with this "
      "plant.");
  add_out(*command, o->out);
  add_plant(*command, o->plant);
  command->callback([o] {
    ZWidthGrid by_hands = hands_zwidth_grid();
    std::string table;
    if (o->plant.empty()) {
      const ZWidthGrid grid = full_zwidth_grid();
      table = zwidth_table(write_zwidth(o->out, grid), grid);
    } else {
      by_hands.plant = load_plant(o->plant);
      by_hands.delays = {0.0};
      std::filesystem::create_directories(o->out);
    }
    const auto cells = map_zwidth(by_hands);
    write_zwidth_hands(o->out, cells);
    std::cout << table << zwidth_hands_table(cells)
              << placed(o->plant.empty() ? "Map and pictures" : "Table", o->out);
  });
}

void add_frontier(CLI::App& app) {
  struct Options {
    std::string out = "frontier", plant;
    bool told = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "frontier",
      "Map the stiffness that each law displays on real devices, by what is known of the hand");
  command->footer(
      "Eight hands at walls, a corner, an edge, a sphere, a torus, friction and taps, by law x "
      "device damping x wall x delay;\nand laws of other papers at some of them. Writes "
      "frontier.json, frontier.csv and three pictures. Some minutes\non two cores; all but the "
      "cost is deterministic. docs/lab/frontier.md says how to read it.\n"
      "With --plant: first presses and taps of the same hands on devices with this plant, without "
      "pictures; shaped runs as\na whole session.");
  add_out(*command, o->out);
  add_plant(*command, o->plant);
  command->add_flag("--told", o->told,
                    "With --plant: the laws and accounts are told the lag of its motors, as by "
                    "actuation_lag of a device file");
  command->callback([o] {
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

void add_compare(CLI::App& app) {
  struct Options {
    std::string out = "compare";
    CompareLoop loop;
    double delay_ms = 0.0;
    std::string scene, link, device = "simulated", plant, path = "press";
    double press = 3.0, duration = 4.0;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "compare", "Every method on walls, edges, bumps, friction and a tap, or over your own scene");
  command->footer(
      "Without --scene: writes compare.json, compare.csv, compare.png, compare_hands.csv (eight "
      "hands) and, measured on\nthis machine, compare_cost.csv. All but the cost is deterministic. "
      "docs/lab/laboratory.md says how to "
      "read "
      "it.\n"
      "With --scene: whole sessions over the link, in virtual time; writes methods_over_link.csv "
      "and "
      ".json,\n"
      "the same bytes every time. Example:\n"
      "  feltwire-lab compare --scene scenes/bunny.json --link delay=15,loss=2 --device simulated");
  add_out(*command, o->out);
  CLI::Option* scene = command->add_option("--scene", o->scene, "Scene file to feel");
  command->add_option("--link", o->link, "Network between hand and scene; docs/link.md")
      ->needs(scene);
  command->add_option("--device", o->device, "A built-in device, or FILE.json (docs/devices.md)")
      ->needs(scene)
      ->capture_default_str();
  command
      ->add_option("--plant", o->plant,
                   "FILE.json with the lag of its motors, their transmission and more, which the "
                   "methods are not told (docs/devices.md)")
      ->needs(scene);
  command
      ->add_option("--path", o->path, "Movement of the hand: press|slide|orbit|figure-eight|taps")
      ->needs(scene)
      ->capture_default_str();
  command->add_option("--press", o->press, "Force with which the hand presses [N]")
      ->needs(scene)
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  command->add_option("--duration", o->duration, "[s] of each session")
      ->needs(scene)
      ->capture_default_str();
  command->add_option("--damping", o->loop.damping, "b: the device's own damping [N s/m]")
      ->capture_default_str()
      ->excludes(scene);
  command->add_option("--rate", o->loop.rate, "Servo rate [Hz]")->capture_default_str();
  command->add_option("--delay", o->delay_ms, "Round trip [ms], rounded up to whole samples")
      ->capture_default_str()
      ->excludes(scene);
  command->callback([o] {
    if (o->scene.empty()) {
      o->loop.delay = o->delay_ms * 1e-3;
      const Comparison result = write_compare(o->out, o->loop);
      std::cout << compare_table(result.rows) << compare_hands_table(result.hands)
                << placed("Tables and picture", o->out);
      return;
    }
    const Scene felt = load_scene(o->scene);
    OverLinkTask task{.hand = press_at_start(felt, o->press),
                      .link = parse_link(o->link),
                      .device = device_spec(o->device),
                      .plant = o->plant.empty() ? Plant{} : load_plant(o->plant),
                      .rate = o->loop.rate,
                      .duration = o->duration};
    task.hand.path = hand_path(o->path);
    const auto rows = run_over_link(felt, task);
    write_over_link(o->out, rows);
    std::cout << over_link_table(rows) << placed("Tables", o->out);
  });
}

void add_extremes(CLI::App& app, int& status) {
  struct Options {
    std::string out = "extremes";
    double assumed_damping = 1.0;
    int hands = 10;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "extremes", "Every method at the limits of the number range, in double and float");
  command->footer(
      "Writes extremes.csv, extremes.json and extremes.png; deterministic. Exit status 1 when any "
      "row rendered\nNaN, Inf or more than the limit, or broke the energy promise of its method. "
      "docs/lab/precision.md says how to read it.");
  add_out(*command, o->out);
  command
      ->add_option(
          "--assumed-damping", o->assumed_damping,
          "The damping that the bounds assume, over the real damping. Above 1, such as 1.05, the "
          "rows must fail")
      ->capture_default_str();
  command->add_option("--hands", o->hands, "Hands for each stress, five kinds in turn")
      ->capture_default_str();
  command->callback([o, &status] {
    const auto rows = run_extremes(o->assumed_damping, o->hands);
    write_extremes(o->out, rows);
    std::cout << extremes_table(rows) << placed("Table and picture", o->out);
    status = all_passed(rows) ? 0 : 1;
  });
}

void add_rate(CLI::App& app) {
  add_study(
      app, "rate", "rate", "Speed against accuracy, by servo rate and by arithmetic",
      "Writes rate.csv, rate.json, rate.png and rate_hands.csv (eight hands), the same bytes every "
      "time; and what this\nmachine took for it, rate_cost.csv and rate_cost.png. "
      "docs/lab/trade.md is its page.",
      "Tables and pictures", [](const std::string& out) {
        const RateGrid grid;
        const auto cells = run_rate(grid);
        const auto costs = measure_rate_cost();
        write_rate(out, grid, cells, costs);
        const auto by_hands = run_rate(hands_rate_grid());
        write_rate_hands(out, by_hands);
        return rate_table(cells) + '\n' + rate_cost_table(grid, costs) + rate_hands_table(by_hands);
      });
}

void add_where_to_bound(CLI::App& app, int& status) {
  struct Options {
    std::string out = "sides";
    WhereToBoundGrid grid;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "where-to-bound", "Compare bounds at server, client or both: over delay, jitter and loss");
  command->footer(
      "Whole sessions in virtual time. Writes sides.csv, sides.json, sides.png and sides_hands.csv "
      "(eight hands), the\nsame bytes every time; a minute of CPU. Exit status 1 when a port that "
      "is bounded delivered more "
      "energy than the device burned.\ndocs/network.md says how to read it.");
  add_out(*command, o->out);
  command
      ->add_option(
          "--assumed-damping", o->grid.assumed_damping,
          "The damping that the bounds assume, over the real damping. Above 1 it must fail")
      ->capture_default_str();
  command->callback([o, &status] {
    const auto cells = run_where_to_bound(o->grid);
    write_where_to_bound(o->out, cells);
    WhereToBoundGrid hands = hands_where_to_bound_grid();
    hands.assumed_damping = o->grid.assumed_damping;
    const auto by_hands = run_where_to_bound(hands);
    write_where_to_bound_hands(o->out, by_hands);
    std::cout << where_to_bound_table(cells) << where_to_bound_hands_table(by_hands)
              << placed("Tables and picture", o->out);
    status = bounds_hold(cells) && bounds_hold(by_hands) ? 0 : 1;
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
      "deadband", "Datagrams that a perceptual deadband saves, and its force error");
  command->footer(
      "Simulated hands by deadband and fraction, in whole sessions in virtual time. Writes "
      "deadband.csv,\ndeadband.json and deadband.png, the same bytes every time. docs/network.md "
      "says how to read it.");
  add_out(*command, o->out);
  command->add_option("--recording", o->recording,
                      "FILE.csv (t,x,y,z) that is also replayed over a plane at z = 0");
  command->add_option("--bounding", o->side, "Where the bound runs: server, client or both")
      ->capture_default_str();
  command->add_option("--link", o->link, "Network between them (docs/link.md)")
      ->capture_default_str();
  command->add_option("--keep-alive", o->grid.parameters.keep_alive, "[s] longest silence")
      ->capture_default_str();
  command
      ->add_option("--hold-time", o->grid.parameters.hold_time,
                   "[s] a command older than half of it fades")
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
      "A local contact model against forces alone, over round trips and rates",
      "Writes local_model.csv, local_model.json and local_model.png, the same bytes every time.\n"
      "docs/network.md says how to read it.",
      "Table and picture", [](const std::string& out) {
        const auto cells = run_local_model();
        write_local_model(out, cells);
        return local_model_table(cells);
      });
}

void add_teleop(CLI::App& app) {
  struct Options {
    std::string out = "teleop";
    bool quick = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "teleop", "Every law of bilateral teleoperation on one bench, over delay, jitter and loss");
  command->footer(
      "A hand, a robot and its environment, in one degree of freedom and virtual time; and our own "
      "law with a simulated arm\nin three. Writes teleop.json, teleop.csv, teleop.png and "
      "arm.json, "
      "the same bytes every time.\ndocs/teleoperation.md says how to read it.");
  add_out(*command, o->out);
  command->add_flag("--quick", o->quick, "Two round trips and two links only");
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
  add_contact_frame_options(app);
  add_zwidth(app);
  add_frontier(app);
  add_torque(app, status);
  add_convex_parts(app);
  add_compare(app);
  add_extremes(app, status);
  add_rate(app);
  add_where_to_bound(app, status);
  add_deadband(app);
  add_local_model(app);
  add_teleop(app);
  add_trade(app);
}

}  // namespace feltwire
