// feltwire-lab: experiments and filters.

#include <CLI/CLI.hpp>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <thread>

#include "client/report.hpp"
#include "sim/choices.hpp"
#include "sim/compare.hpp"
#include "sim/deadband_study.hpp"
#include "sim/extremes.hpp"
#include "sim/figures.hpp"
#include "sim/filters.hpp"
#include "sim/link_relay.hpp"
#include "sim/local_model.hpp"
#include "sim/rate.hpp"
#include "sim/report_table.hpp"
#include "sim/sides.hpp"
#include "sim/trade_network.hpp"
#include "sim/zwidth.hpp"

namespace {

using namespace feltwire;

void report_refused(std::size_t rows) {
  if (rows > 0)
    std::cerr << "feltwire-lab: " << rows
              << " row(s) were not finite or absurd and gave zero force\n";
}

void add_figures(CLI::App& app) {
  auto out = std::make_shared<std::string>("figures");
  CLI::App* command = app.add_subcommand("figures", "Reproduce the paper's Figures 2, 3, 5 and 6");
  command->footer(
      "Writes figures.json, one CSV a run (t [s], x,y,z [m], ex..ez and fx..fz commanded elastic "
      "and frictional,\n"
      "rx..rz rendered [N on the hand], energy_x..z flow-in [J]) and PNG pictures with the gnuplot "
      "scripts that drew\n"
      "them. In process and deterministic: the same build writes the same numbers.");
  command->add_option("--out", *out, "Folder to write to; made when missing")
      ->capture_default_str();
  command->callback([out] {
    const auto runs = write_figures(*out);
    std::cout << figures_table(runs) << "\nPictures, data and figures.json are in "
              << std::filesystem::absolute(*out).lexically_normal().string() << '\n';
  });
}

void add_choices(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "choices", "Measure what the contact frame leaves open: projection, storage");
  command->footer("Joint or cone, minimal or elastic: the tables of docs/bounding.md.");
  command->callback([] { std::cout << choices_tables(); });
}

Damping damping_of(const std::vector<double>& n) {
  switch (n.size()) {
    case 1:
      return n[0];
    case 3:
      return Vec3(n[0], n[1], n[2]);
    case 6:
      return Mat3{{n[0], n[3], n[4]}, {n[3], n[1], n[5]}, {n[4], n[5], n[2]}};
    default:
      throw std::invalid_argument("--damping takes 1, 3 or 6 numbers, got " +
                                  std::to_string(n.size()));
  }
}

void add_zwidth(CLI::App& app) {
  auto out = std::make_shared<std::string>("zwidth");
  CLI::App* command = app.add_subcommand(
      "zwidth", "Map the stiffest wall without oscillation, by method, device and loop");
  command->footer(
      "A simulated hand presses a wall with 3 N, by method x device damping x servo rate x delay.\n"
      "Writes zwidth.json, zwidth.csv and a picture a damping (zwidth_bB.png). A minute or two on "
      "two cores;\ndeterministic. docs/laboratory.md says how to read it.");
  command->add_option("--out", *out, "Folder to write to; made when missing")
      ->capture_default_str();
  command->callback([out] {
    const ZWidthGrid grid = full_zwidth_grid();
    std::cout << zwidth_table(write_zwidth(*out, grid), grid) << "\nMap and pictures are in "
              << std::filesystem::absolute(*out).lexically_normal().string() << '\n';
  });
}

void add_compare(CLI::App& app) {
  struct Options {
    std::string out = "compare";
    CompareLoop loop;
    double delay_ms = 0.0;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("compare", "Every method on walls, edges, bumps, friction and a tap");
  command->footer(
      "Writes compare.json, compare.csv, compare.png and, measured on this machine,\n"
      "compare_cost.csv. All but the cost is deterministic. docs/laboratory.md says how to read "
      "it.");
  command->add_option("--out", o->out, "Folder to write to; made when missing")
      ->capture_default_str();
  command->add_option("--damping", o->loop.damping, "b: the device's own damping [N s/m]")
      ->capture_default_str();
  command->add_option("--rate", o->loop.rate, "Servo rate [Hz]")->capture_default_str();
  command->add_option("--delay", o->delay_ms, "Round trip [ms], rounded up to whole samples")
      ->capture_default_str();
  command->callback([o] {
    o->loop.delay = o->delay_ms * 1e-3;
    std::cout << compare_table(write_compare(o->out, o->loop)) << "\nTable and picture are in "
              << std::filesystem::absolute(o->out).lexically_normal().string() << '\n';
  });
}

void add_extremes(CLI::App& app, int& status) {
  struct Options {
    std::string out = "extremes";
    double told_damping = 1.0;
    int hands = 10;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "extremes", "Every method at the ends of what numbers can say, in double and float");
  command->footer(
      "Writes extremes.csv, extremes.json and extremes.png; deterministic. Exit status 1 when any "
      "row rendered\nNaN, Inf or more than the limit, or broke the energy promise of its method. "
      "docs/precision.md says how to read it.");
  command->add_option("--out", o->out, "Folder to write to; made when missing")
      ->capture_default_str();
  command
      ->add_option(
          "--told-damping", o->told_damping,
          "What the bounds are told over the damping there is. Above 1, say 1.05, the rows "
          "must fail")
      ->capture_default_str();
  command->add_option("--hands", o->hands, "Hands to a strain, five kinds in turn")
      ->capture_default_str();
  command->callback([o, &status] {
    const auto rows = run_extremes(o->told_damping, o->hands);
    write_extremes(o->out, rows);
    std::cout << extremes_table(rows) << "\nTable and picture are in "
              << std::filesystem::absolute(o->out).lexically_normal().string() << '\n';
    status = all_passed(rows) ? 0 : 1;
  });
}

void add_rate(CLI::App& app) {
  auto out = std::make_shared<std::string>("rate");
  CLI::App* command =
      app.add_subcommand("rate", "Speed against accuracy, by servo rate and by arithmetic");
  command->footer(
      "Writes rate.csv, rate.json and rate.png, the same bytes every time; and what this machine "
      "took for it,\nrate_cost.csv and rate_cost.png. docs/trade.md is its page.");
  command->add_option("--out", *out, "Folder to write to; made when missing")
      ->capture_default_str();
  command->callback([out] {
    const RateGrid grid;
    const auto cells = run_rate(grid);
    const auto costs = measure_rate_cost();
    write_rate(*out, grid, cells, costs);
    std::cout << rate_table(cells) << '\n'
              << rate_cost_table(grid, costs) << "\nTables and pictures are in "
              << std::filesystem::absolute(*out).lexically_normal().string() << '\n';
  });
}

void add_sides(CLI::App& app, int& status) {
  struct Options {
    std::string out = "sides";
    SidesGrid grid;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "sides", "Who should bound, server, client or both: over delay, jitter and loss");
  command->footer(
      "Whole sessions in virtual time. Writes sides.csv, sides.json and sides.png, the same bytes "
      "every time; half a\nminute of CPU. Exit status 1 when a bound at the client's port "
      "delivered "
      "more energy than the device burned.\ndocs/network.md says how to read it.");
  command->add_option("--out", o->out, "Folder to write to; made when missing")
      ->capture_default_str();
  command
      ->add_option(
          "--told-damping", o->grid.told_damping,
          "What the bounds are told over the damping there is. Above 1, say 1.05, it must fail")
      ->capture_default_str();
  command->callback([o, &status] {
    const auto cells = run_sides(o->grid);
    write_sides(o->out, cells);
    std::cout << sides_table(cells) << "\nTable and picture are in "
              << std::filesystem::absolute(o->out).lexically_normal().string() << '\n';
    status = client_bounds_hold(cells) ? 0 : 1;
  });
}

void add_trade(CLI::App& app) {
  CLI::App* trade = app.add_subcommand("trade", "What more of one thing costs in another");
  trade->require_subcommand(1);
  auto out = std::make_shared<std::string>("trade-network");
  CLI::App* network = trade->add_subcommand(
      "network", "Bandwidth against force error, direction error and delay, over three links");
  network->footer(
      "Writes trade_network.csv, trade_network.json and trade_network.png, the same bytes every "
      "time.\nSome minutes of CPU time. docs/trade.md is its page.");
  network->add_option("--out", *out, "Folder to write to; made when missing")
      ->capture_default_str();
  network->callback([out] {
    constexpr double kTaskTime = 4.0;  // [s]
    const auto settings = traffic_settings();
    const auto cells = run_trade_network(settings, kTaskTime);
    write_trade_network(*out, settings, cells);
    std::cout << trade_network_table(settings, cells) << '\n'
              << trade_network_cost_table(settings, cells) << "\nData and picture are in " << *out
              << '\n';
  });
}

Recording recording_from(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": cannot be read; give a CSV with t,x,y,z");
  return read_recording(in, file);
}

void add_deadband(CLI::App& app) {
  struct Options {
    std::string out = "deadband", recording, side = std::string(name(SessionParameters{}.side)),
                link = "delay=0";
    DeadbandGrid grid;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "deadband", "Datagrams that a perceptual deadband saves, and what it costs the force");
  command->footer(
      "Simulated hands by deadband and fraction, in whole sessions in virtual time. Writes "
      "deadband.csv,\ndeadband.json and deadband.png, the same bytes every time. docs/network.md "
      "says how to read it.");
  command->add_option("--out", o->out, "Folder to write to; made when missing")
      ->capture_default_str();
  command->add_option("--recording", o->recording,
                      "FILE.csv (t,x,y,z) that is replayed over a plane at z = 0, too");
  command->add_option("--bounding", o->side, "Where the bound runs: server, client or both")
      ->capture_default_str();
  command->add_option("--link", o->link, "Between them (docs/network.md)")->capture_default_str();
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
    if (!o->recording.empty()) recording = recording_from(o->recording);
    const auto rows = run_deadband(deadband_tasks(recording), grid);
    write_deadband(o->out, grid, rows);
    std::cout << deadband_table(rows) << "\nTable and picture are in "
              << std::filesystem::absolute(o->out).lexically_normal().string() << '\n';
  });
}

void add_local_model(CLI::App& app) {
  auto out = std::make_shared<std::string>("local_model");
  CLI::App* command = app.add_subcommand(
      "local-model", "A local contact model against forces alone, over round trips and rates");
  command->footer(
      "Writes local_model.csv, local_model.json and local_model.png, the same bytes every time.\n"
      "docs/network.md says how to read it.");
  command->add_option("--out", *out, "Folder to write to; made when missing")
      ->capture_default_str();
  command->callback([out] {
    const auto cells = run_local_model();
    write_local_model(*out, cells);
    std::cout << local_model_table(cells) << "\nTable and picture are in "
              << std::filesystem::absolute(*out).lexically_normal().string() << '\n';
  });
}

void add_bound(CLI::App& app) {
  struct Options {
    std::string mode = "contact_frame", projection = "joint", storage = "minimal",
                reference = "zero";
    BoundingConfig config;
    double c1 = 0.0, c2 = 0.0;
    std::vector<double> damping;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "bound", "Filter: run a bounding method over rows of movement and command");
  command->footer(
      "stdin   CSV with a header; columns in any order, others are ignored:\n"
      "          dx,dy,dz  displacement since the last row [m]\n"
      "          ex,ey,ez  elastic command [N, on the hand]\n"
      "          fx,fy,fz  frictional command [N, on the hand]\n"
      "stdout  CSV: rx,ry,rz  rendered force [N, on the hand]\n"
      "             energy    delivered to the hand so far [J], sum of f(n-1).dx(n)\n"
      "             active    1 where the bound changed the command\n"
      "A row with nan or inf renders zero. Example:\n"
      "  printf 'dx,dy,dz,ex,ey,ez,fx,fy,fz\\n0,-1e-4,0,0,4,0,0,0,0\\n' | feltwire-lab bound "
      "--period 0.001 --damping 0.5");
  std::string modes;
  for (const auto mode : kBoundingModeNames)
    modes += (modes.empty() ? "" : ", ") + std::string(mode);
  command->add_option("--mode", o->mode, modes)->capture_default_str();
  command->add_option("--period", o->config.period, "T: time that one force is held [s]")
      ->required();
  command
      ->add_option(
          "--damping", o->damping,
          "The device's own damping [N s/m]: b, or bx,by,bz along the axes, or a symmetric "
          "positive definite matrix xx,yy,zz,xy,xz,yz")
      ->delimiter(',')
      ->required();
  CLI::Option* c1 =
      command->add_option("--c1", o->c1, "The paper's c1 [N/m]; default b/T (paper's modes only)");
  CLI::Option* c2 = command->add_option(
      "--c2", o->c2, "The paper's c2 [N/m]; at most c1, default c1 (paper's modes only)");
  command->add_option("--max-force", o->config.max_force,
                      "Saturation after the bound [N]; default none");
  command->add_option("--projection", o->projection, "joint or cone (contact_frame only)")
      ->capture_default_str();
  command->add_option("--storage", o->storage, "minimal or elastic (contact_frame only)")
      ->capture_default_str();
  command->add_option("--reference", o->reference, "zero or following (passivity_control* only)")
      ->capture_default_str();
  command->callback([o, c1, c2] {
    o->config.mode = bounding_mode(o->mode);
    o->config.reference = passivity_reference(o->reference);
    o->config.damping = damping_of(o->damping);
    o->config.projection = projection(o->projection);
    o->config.storage = storage(o->storage);
    if (*c1) o->config.c1 = o->c1;
    if (*c2) o->config.c2 = o->c2;
    report_refused(filter_bound(std::cin, std::cout, o->config));
  });
}

void add_touch(CLI::App& app) {
  auto scene = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("touch", "Filter: what a scene answers at each position of a movement");
  command->footer(
      "stdin   CSV with a header; columns in any order, others are ignored: t [s], x,y,z [m]\n"
      "stdout  CSV: ex,ey,ez elastic and fx,fy,fz frictional force [N, on the hand]\n"
      "The rows are one movement: friction and velocity (difference of two rows) remember. "
      "Example:\n"
      "  printf 't,x,y,z\\n0,0,0,0.001\\n0.001,0,0,-0.001\\n' | feltwire-lab touch --scene "
      "scenes/plane.json");
  command->add_option("--scene", *scene, "Scene file (docs/scenes.md)")->required();
  command->callback(
      [scene] { report_refused(filter_touch(std::cin, std::cout, load_scene(*scene))); });
}

void add_summary(CLI::App& app) {
  auto files = std::make_shared<std::vector<std::filesystem::path>>();
  CLI::App* command = app.add_subcommand("summary", "Show the reports of clients side by side");
  command->add_option("REPORT", *files, "JSON reports that feltwire-client wrote")->required();
  command->callback([files] { std::cout << report_table(*files); });
}

/// Relays until SIGINT or SIGTERM.
void relay(const LinkRelayOptions& options, const std::string& report) {
  if (!report.empty()) check_writable(report);
  sigset_t endings;
  sigemptyset(&endings);
  sigaddset(&endings, SIGINT);
  sigaddset(&endings, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &endings, nullptr);  // in the thread below, too

  LinkRelay link(options);
  std::cout << "relaying: control tcp " << link.control_port() << " to "
            << to_string(options.server) << std::endl;
  std::thread thread([&] { link.run(); });
  int signal = 0;
  sigwait(&endings, &signal);
  link.stop();
  thread.join();
  if (!report.empty()) write_whole(report, link.report());
}

void add_link(CLI::App& app) {
  struct Options {
    LinkRelayOptions relay;
    std::string link, to, report;
  };
  auto o = std::make_shared<Options>();
  o->relay.port = 7500;
  CLI::App* command =
      app.add_subcommand("link", "Relay between clients and a server, over an emulated link");
  command->footer(link_help() +
                  "Example, in two terminals beside a server on 7400:\n"
                  "  feltwire-lab link wifi,loss=5,seed=3 --listen 7500 --to localhost:7400\n"
                  "  feltwire-client --connect localhost:7500 --scene room --duration 10");
  command->add_option("LINK", o->link, "What the link does, see below")->required();
  command
      ->add_option("--listen", o->relay.port,
                   "Port for clients (tcp); the scenes' (udp) follow it; 0: any")
      ->capture_default_str();
  command->add_option("--address", o->relay.address, "Address to listen on")->capture_default_str();
  command->add_option("--to", o->to, "HOST:PORT of the server's control port")->required();
  command->add_option("--report", o->report, "FILE.json that gets the counters at the end");
  command->callback([o] {
    o->relay.link = parse_link(o->link);
    o->relay.server = parse_endpoint(o->to);
    o->relay.scene_opened = [](std::uint16_t own, std::uint16_t server) {
      std::cout << "relaying: scene udp " << own << " to " << server << std::endl;
    };
    relay(o->relay, o->report);
  });
}

}  // namespace

int main(int argc, char** argv) {
  std::ios::sync_with_stdio(false);
  std::cin.tie(nullptr);
  CLI::App app{"feltwire-lab: experiments on the energy bound, and filters", "feltwire-lab"};
  app.require_subcommand(1);
  add_figures(app);
  add_choices(app);
  add_zwidth(app);
  add_compare(app);
  int status = 0;  // of a command that judges
  add_extremes(app, status);
  add_rate(app);
  add_sides(app, status);
  add_trade(app);
  add_deadband(app);
  add_local_model(app);
  add_bound(app);
  add_touch(app);
  add_summary(app);
  add_link(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::exception& e) {
    std::cerr << "feltwire-lab: " << e.what() << '\n';
    return 1;
  }
  return status;
}
