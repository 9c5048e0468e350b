// The program feltwire-lab. It runs experiments and filters.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "client/hands/plant_file.hpp"
#include "client/run/output_files.hpp"
#include "core/base/visible_text.hpp"
#include "core/bounding/device_account.hpp"
#include "core/build_info/build_info.hpp"
#include "core/device/device_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "protocol/net/ports.hpp"
#include "sim/emulator/link_relay.hpp"
#include "sim/hands/amplifier_lag.hpp"
#include "sim/lab/filters.hpp"
#include "sim/lab/recording_tables.hpp"
#include "sim/lab/study_commands.hpp"
#include "sim/replay/replay_command.hpp"
#include "sim/report/report_table.hpp"

namespace {

using namespace feltwire;

void report_refused(std::size_t rows) {
  if (rows > 0)
    std::cerr << "feltwire-lab: " << rows
              << " row(s) were not finite or out of range and gave zero force\n";
}

/// Former names of subcommands and options, each with its present name.
constexpr std::pair<std::string_view, std::string_view> kRenamed[] = {
    {"sides", "where-to-bound"},
    {"parts", "convex-parts"},
    {"--told-damping", "--assumed-damping"}};

/// Returns the advice for a command line with an error, such as "; sides is now where-to-bound".
std::string lab_advice(const CLI::Error& error, const CLI::App& app) {
  for (const std::string& word : app.remaining(true))
    for (const auto& [before, now] : kRenamed)
      if (word.substr(0, word.find('=')) == before)
        return "; " + std::string(before) + " is now " + std::string(now);
  return advice(error, app);
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
      throw std::invalid_argument("a damping takes 1, 3 or 6 numbers, got " +
                                  std::to_string(n.size()));
  }
}

/// Copies the device's values into `config`, as in a session. A limit in `config` remains if it is
/// smaller than the device's limit.
void take_device(const DeviceSpec& device, BoundingConfig& config) {
  config.damping = device.damping;
  config.quantum = device.position_resolution;
  config.lag = device.actuation.lag;
  config.max_force = std::min(config.max_force, device.max_force);
  config.rotation = device.rotation_actuated > 0;
  if (!config.rotation) return;
  config.rotational_damping = device.rotational_damping;
  config.max_torque = std::min(config.max_torque, device.max_torque);
}

void add_bound(CLI::App& app) {
  struct Options {
    std::string mode = std::string(kDefaultMethod), projection = "joint", storage = "minimal",
                reference = "zero";
    BoundingConfig config;
    double c1 = 0.0, c2 = 0.0;
    std::vector<double> damping, rotational_damping;
    std::string spec, plant;
    bool account = false, told = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "bound", "Filter: apply a bounding method to rows of movement and command");
  command->footer(
      "stdin   CSV with a header; columns in any order, others are ignored:\n"
      "          dx,dy,dz  displacement since the last row [m]\n"
      "          ex,ey,ez  elastic command [N, on the hand]\n"
      "          fx,fy,fz  frictional command [N, on the hand]\n"
      "stdout  CSV: rx,ry,rz  rendered force [N, on the hand]\n"
      "             energy    delivered to the hand so far [J], sum of f(n-1).dx(n)\n"
      "             active    1 if the bound changed the command\n"
      "With --rotational-damping the device also rotates:\n"
      "stdin   also ax,ay,az  rotation vector since the last row [rad]\n"
      "             tx,ty,tz  torque command [N m, on the hand]\n"
      "stdout  also rtx,rty,rtz  rendered torque [N m, on the hand], before energy\n"
      "Optional columns of stdin:\n"
      "        hold   time since the last row [s], else --period\n"
      "        local  1 if the command belongs to the device's current position, else 0\n"
      "        n1x,n1y,n1z to n3x,n3y,n3z  normals of the touched walls, 0,0,0 for none\n"
      "With --account the energy account limits the force after the method. The last column is "
      "balance [J].\n"
      "With --plant the last column is motor: the energy [J] that the true motor behind the "
      "plant's\n"
      "amplifier gave so far, if the movement of each row was even.\n"
      "A row with nan or inf renders zero force. Example:\n"
      "  printf 'dx,dy,dz,ex,ey,ez,fx,fy,fz\\n0,-1e-4,0,0,4,0,0,0,0\\n' | feltwire-lab bound "
      "--period 0.001 --damping 0.5\n"
      "Methods:\n" +
      bounding_method_summaries());
  command->add_option("--mode", o->mode, "Bounding method, see below")->capture_default_str();
  command->add_option("--period", o->config.period, "[s] Time T for which a force is held")
      ->required();
  command
      ->add_option("--damping", o->damping,
                   "[N s/m] Damping of the device: b, or bx,by,bz along the axes, or a symmetric "
                   "positive definite matrix xx,yy,zz,xy,xz,yz. Default: from --spec")
      ->delimiter(',');
  CLI::Option* spec = command->add_option(
      "--spec", o->spec,
      "Specification of the device: a built-in name or FILE.json. It sets damping, encoder "
      "quantum, largest force, lag and, for a device with torque, rotation");
  command
      ->add_flag("--account", o->account,
                 "Apply the device's energy account after the method, as a session does")
      ->needs(spec);
  CLI::Option* plant =
      command->add_option("--plant", o->plant,
                          "FILE.json with the amplifier of the motor (docs/devices.md). The rows "
                          "are the movement, so the rest of the plant has no effect");
  command->add_flag("--told", o->told, "The method and the account use the motor lag of the plant")
      ->needs(plant);
  CLI::Option* turns = command
                           ->add_option("--rotational-damping", o->rotational_damping,
                                        "[N m s/rad] Rotational damping of the device, in the same "
                                        "forms. The torque is bounded too")
                           ->delimiter(',');
  command
      ->add_option("--max-torque", o->config.max_torque,
                   "[N m] Torque limit after the bound. Default: none")
      ->needs(turns);
  CLI::Option* c1 =
      command->add_option("--c1", o->c1, "[N/m] Constant c1 of the paper's methods. Default: b/T");
  CLI::Option* c2 = command->add_option(
      "--c2", o->c2, "[N/m] Constant c2 of the paper's methods, at most c1. Default: c1");
  command->add_option("--max-force", o->config.max_force,
                      "[N] Force limit after the bound. Default: none");
  command->add_option("--projection", o->projection, "Projection of contact_frame: joint or cone")
      ->capture_default_str();
  command
      ->add_option("--storage", o->storage, "Energy storage of contact_frame: minimal or elastic")
      ->capture_default_str();
  command
      ->add_option("--reference", o->reference,
                   "Reference of passivity_control*: zero or following")
      ->capture_default_str();
  command->callback([o, c1, c2] {
    std::optional<DeviceSpec> device;
    if (!o->spec.empty()) device = device_spec(o->spec);
    std::optional<Plant::Amplifier> amplifier;
    if (!o->plant.empty()) amplifier = load_plant(o->plant).amplifier;
    if (device && o->told) {
      device->actuation.lag = lag_of(*amplifier).time;
      device->actuation.kind = lag_of(*amplifier).kind;
    }
    if (device) take_device(*device, o->config);
    if (o->told) o->config.lag = lag_of(*amplifier).time;
    if (!device && o->damping.empty())
      throw std::invalid_argument("give --damping, the device's own, or --spec");
    if (!o->rotational_damping.empty()) {
      o->config.rotation = true;
      o->config.rotational_damping = damping_of(o->rotational_damping);
    }
    o->config.mode = bounding_method(o->mode).name;
    o->config.reference = passivity_reference(o->reference);
    if (!o->damping.empty()) o->config.damping = damping_of(o->damping);
    o->config.projection = projection(o->projection);
    o->config.storage = storage(o->storage);
    if (*c1) o->config.c1 = o->c1;
    if (*c2) o->config.c2 = o->c2;
    std::optional<AccountConfig> account;
    if (o->account) account = account_config(*device, o->config.period);
    report_refused(filter_bound(std::cin, std::cout, o->config, account, amplifier));
  });
}

void add_touch(CLI::App& app) {
  auto scene = std::make_shared<std::string>();
  auto tool = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "touch", "Filter: compute the force of a scene at each position of a movement");
  command->footer(
      "stdin   CSV with a header; columns in any order, others are ignored: t [s], x,y,z [m];\n"
      "        for a tool with a body also qw,qx,qy,qz, its orientation\n"
      "stdout  CSV: ex,ey,ez elastic and fx,fy,fz frictional force [N, on the hand];\n"
      "        for a tool with a body also tx,ty,tz [N m]\n"
      "stderr  warnings about the scene\n"
      "The rows are one movement. Friction and velocity depend on earlier rows. "
      "Example:\n"
      "  printf 't,x,y,z\\n0,0,0,0.001\\n0.001,0,0,-0.001\\n' | feltwire-lab touch --scene "
      "scenes/plane.json");
  command->add_option("--scene", *scene, "Scene file (docs/scenes.md)")->required();
  command->add_option("--tool", *tool, "Name of the tool. Default: the scene's first tool");
  command->callback([scene, tool] {
    const Scene touched = load_scene(*scene);
    for (const std::string& warning : touched.warnings())
      std::cerr << visible(*scene + ": " + warning) << '\n';
    report_refused(filter_touch(std::cin, std::cout, touched, *tool));
  });
}

void add_summary(CLI::App& app) {
  auto files = std::make_shared<std::vector<std::filesystem::path>>();
  CLI::App* command = app.add_subcommand("summary", "Show the reports of clients side by side");
  command->add_option("REPORT", *files, "JSON reports from feltwire-client")->required();
  command->callback([files] { std::cout << report_table(*files); });
}

void add_export(CLI::App& app) {
  struct Options {
    std::vector<std::filesystem::path> files;
    std::string csv, npz;
    bool replies = false, skip_damaged = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("export", "Convert MCAP recordings to CSV files or NumPy arrays");
  command->footer(
      "Give all files of one recording, in their order. A client's recording gives a table of its "
      "ticks, a server's one table per hand. docs/recording.md lists the columns. Examples:\n"
      "  feltwire-lab export hand.mcap --csv hand\n"
      "  feltwire-lab export room.mcap --replies --csv room\n"
      "  feltwire-lab export hand-0001.mcap hand-0002.mcap --npz hand.npz");
  command->add_option("FILE", o->files, "MCAP files from --record or --flight-recorder")
      ->required();
  CLI::Option* csv = command->add_option(
      "--csv", o->csv, "Folder for one CSV file per table. It is created if it is missing");
  command->add_option("--npz", o->npz, "FILE.npz for one array per column")->excludes(csv);
  CLI::Option* replies =
      command->add_flag("--replies", o->replies,
                        "Compute the replies of a server's recording again, and export them too");
  command
      ->add_flag("--skip-damaged", o->skip_damaged,
                 "Export the undamaged chunks of damaged files, and list the missing parts")
      ->excludes(replies);
  command->callback([o] {
    if (o->csv.empty() && o->npz.empty())
      throw std::invalid_argument("export needs --csv DIR or --npz FILE");
    std::vector<NamedFile> read;
    for (const auto& file : o->files) read.push_back({"FILE", file});
    if (!o->npz.empty()) require_different({{"--npz", o->npz}}, read);
    const auto [tables, cuts, missing] = read_recording_tables(
        o->files, o->replies, o->skip_damaged ? Damaged::skip : Damaged::refuse);
    for (const auto& [file, line] : missing)
      std::cerr << visible("feltwire-lab: " + file.string() + ": " + line) << '\n';
    for (const auto& [file, byte] : cuts)
      std::cerr << "feltwire-lab: " << visible(file.string()) << " was cut at byte " << byte
                << ": its last seconds may be missing\n";
    if (tables.empty())
      throw std::runtime_error(o->files.front().string() +
                               ": has no tick of a client and no datagram of a hand; give a file "
                               "that --record or --flight-recorder wrote");
    for (const auto& [topic, table] : tables)
      std::cout << visible(topic) << ": " << table.log_time.size() << " rows\n";
    if (!o->npz.empty()) return write_npz(tables, o->npz);
    for (const auto& file : write_csv_files(tables, o->csv))
      std::cout << "wrote " << visible(file.string()) << '\n';
  });
}

/// Forwards datagrams between clients and server until SIGINT or SIGTERM, then writes the report.
void relay(const LinkRelayOptions& options, const std::string& report) {
  if (!report.empty()) check_writable(report);
  sigset_t endings;
  sigemptyset(&endings);
  sigaddset(&endings, SIGINT);
  sigaddset(&endings, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &endings, nullptr);  // the thread below inherits this mask

  LinkRelay link(options);
  std::cout << "relaying: control tcp " << link.control_port() << ", scenes udp "
            << link.control_port() + 1 << " to " << link.control_port() + options.scenes << ", to "
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
  o->relay.port = kDefaultRelayPort;
  CLI::App* command = app.add_subcommand(
      "link", "Relay datagrams between clients and a server over an emulated link");
  command->footer(link_help() +
                  "Example, in two terminals, with a server on this machine:\n"
                  "  feltwire-lab link wifi,loss=5,seed=3 --to localhost:" +
                  std::to_string(kDefaultPort) +
                  "\n"
                  "  feltwire-client --connect localhost:" +
                  std::to_string(kDefaultRelayPort) + " --scene room --duration 10");
  command->add_option("LINK", o->link, "Emulated link, see below")->required();
  command
      ->add_option(
          "--listen", o->relay.port,
          "Control port for clients (TCP). The next UDP ports are for the scenes. 0: free ports")
      ->capture_default_str();
  command->add_option("--scenes", o->relay.scenes, "Number of scenes of the server to relay")
      ->capture_default_str();
  command->add_option("--address", o->relay.address, "Address to listen on")->capture_default_str();
  command->add_option("--to", o->to, "HOST:PORT of the server's control port")->required();
  command->add_option("--report", o->report,
                      "FILE.json for the counters. It is written at the end");
  command->callback([o] {
    o->relay.link = parse_link(o->link);
    o->relay.server = parse_endpoint(o->to);
    relay(o->relay, o->report);
  });
}

}  // namespace

int main(int argc, char** argv) {
  std::ios::sync_with_stdio(false);
  std::cin.tie(nullptr);
  CLI::App app{"feltwire-lab: runs experiments with the energy bound, and filters", "feltwire-lab"};
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-lab"); },
      "Print version, commit, compiler and build type, and exit");
  app.require_subcommand(1);
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return "feltwire-lab: " + printable_error(error.what() + lab_advice(error, *failed)) +
           "; see --help\n";
  });
  int status = 0;
  add_studies(app, status);
  add_bound(app);
  add_touch(app);
  add_summary(app);
  add_export(app);
  add_replay(app, std::cout, status);
  add_link(app);
  try {
    parse_arguments(app, argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::exception& e) {
    std::cerr << "feltwire-lab: " << printable_error(e.what()) << '\n';
    return 1;
  }
  return status;
}
