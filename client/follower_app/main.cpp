// The program feltwire-follower. It lets a robot follow a hand in a scene of a server.

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "client/command_line/credential_options.hpp"
#include "client/emulated_link/emulated_port.hpp"
#include "client/follower_app/follower_record.hpp"
#include "client/follower_app/follower_report.hpp"
#include "client/follower_app/robots.hpp"
#include "client/follower_app/workspace_option.hpp"
#include "client/followers/follower_loop.hpp"
#include "client/run/output_files.hpp"
#include "core/build_info/build_info.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/config_file.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/suggestion.hpp"

namespace feltwire {
namespace {

constexpr int kBadUsage = 2;
constexpr double kDriverTime = 60.0;        // [s] longest wait for the robot's driver to connect
constexpr std::size_t kLinkRoom = 1 << 13;  // largest number of datagrams in transit, per direction

std::atomic<bool> stopped{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // needed by the signal handler stop()
void stop(int /*signal*/) { stopped.store(true); }

struct FollowerOptionValues {
  std::string config, connect, link, report, record, prior;
  CredentialOptions credentials;
  RobotChoice robot;
  std::optional<std::array<double, 3>> at;
  WorkspaceValues workspace;
  FollowerRun run;
};

void add_options(CLI::App& app, FollowerOptionValues& values) {
  app.set_version_flag("--version", [] { return build_info("feltwire-follower"); });
  app.add_option("--config", values.config,
                 "FILE.json with options: {\"leash\": 5, \"workspace\": [0,0,0,1,1,1]}. The "
                 "command line and the environment override it (docs/teleoperation.md)");
  app.add_option("--connect", values.connect,
                 "HOST:PORT of the server's control port; IPv6 as [::1]:PORT")
      ->required();
  app.add_option("--scene", values.run.scene, "Name of the scene that has the robot's seat")
      ->required();
  app.add_option("--seat", values.run.seat,
                 "Name of the robot's seat. Default: the only seat of the scene");
  app.add_option("--surroundings", values.robot.surroundings,
                 "FILE.json of a scene. The robot is a simulated point mass with an impedance "
                 "controller in this scene");
  app.add_option("--arm", values.robot.arm,
                 "FILE.xml (MJCF) of a seven-axis arm and the objects around it. The robot is this "
                 "simulated arm");
  app.add_option(
      "--socket", values.robot.socket,
      "PATH of a Unix socket. The robot's driver, a program in any language, connects to it");
  app.add_option("--at", values.at,
                 "X,Y,Z [m] Start position of a simulated robot. Default: 0,0,0 for a point, the "
                 "home position for an arm")
      ->delimiter(',');
  app.add_option("--prior", values.prior,
                 "FILE.json of a scene with known surfaces, in the robot's frame. The hand feels a "
                 "surface before the robot touches it. Measured contacts correct the surfaces");
  app.add_option("--name", values.run.name, "Name of this robot in the server's log")
      ->capture_default_str();
  app.add_option("--speed", values.run.options.motion.speed, "[m/s] Speed limit of the target")
      ->capture_default_str();
  app.add_option("--acceleration", values.run.options.motion.acceleration,
                 "[m/s^2] Acceleration limit of the target")
      ->capture_default_str();
  app.add_option("--jerk", values.run.options.motion.jerk, "[m/s^3] Jerk limit of the target")
      ->capture_default_str();
  app.add_option("--leash", values.run.options.leash,
                 "[N] Largest force by which the target pulls the robot")
      ->capture_default_str();
  app.add_option("--workspace", values.workspace.box,
                 "X0,Y0,Z0,X1,Y1,Z1 [m] Box that limits the robot's target, in addition to the "
                 "workspace of the seat")
      ->delimiter(',');
  app.add_option(
         "--keep-out", values.workspace.keep_out,
         "X,Y,Z,HX,HY,HZ,R [m] Body that the robot's target avoids, in addition to the bodies of "
         "the seat. The body is a box with centre X,Y,Z and half extents HX,HY,HZ, enlarged by R. "
         "0,0,0 as half extents: a ball. Repeat the option for up to 8 bodies")
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--lock", values.workspace.lock,
                 "Axes that stay constant while a hand is engaged, in addition to the locked axes "
                 "of the seat: any of x,y,z,rotation")
      ->delimiter(',');
  app.add_option("--duration", values.run.duration,
                 "[s] Length of the run. 0: run until it is stopped")
      ->capture_default_str();
  app.add_option("--reconnect", values.run.patience,
                 "[s] Try to reconnect for this time after a lost session")
      ->capture_default_str();
  app.add_option("--report", values.report,
                 "FILE.json for the results of the run (docs/teleoperation.md)");
  app.add_option("--record", values.record,
                 "FILE.csv for a recording of every sample (docs/teleoperation.md)");
  app.add_option("--link", values.link,
                 "Emulated network, in the syntax of feltwire-client --link");
  add_credential_options(app, values.credentials);
}

/// Prints an error of the command line or of the configuration file. Returns the exit status.
int refuse(const std::string& what, int status) {
  std::fprintf(stderr, "feltwire-follower: %s\n", printable_error(what).c_str());
  return status;
}

int follow(FollowerOptionValues& values) {
  if (values.at) values.robot.at = Vec3((*values.at)[0], (*values.at)[1], (*values.at)[2]);
  check(values.robot);
  if (!values.prior.empty()) values.run.options.surfaces = load_surfaces(values.prior);
  values.run.options.workspace = workspace_of(values.workspace);
  values.run.server = {parse_endpoint(values.connect), credentials(values.credentials)};
  if (!values.link.empty())
    values.run.open_port = [link = parse_link(values.link)](const Address& scene) {
      return std::make_unique<EmulatedPort>(open_udp_port(scene), TwoWayLink(link, 0, kLinkRoom));
    };
  values.run.on_join = [] { std::fprintf(stderr, "feltwire-follower: has the robot's seat\n"); };
  if (!values.report.empty()) check_writable(values.report);
  const std::unique_ptr<Follower> robot = make_robot(values.robot, kDriverTime);
  std::optional<FollowerRecord> record;
  if (!values.record.empty()) {
    record.emplace(values.record);
    values.run.on_sample = [&record](const RobotState& said, const RobotTarget& target) {
      record->add(said, target);
    };
  }
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  const FollowerResult result = run_follower(*robot, values.run, stopped);
  std::printf("%s\n", report_line(result).c_str());
  if (!values.report.empty())
    write_whole(values.report, report_json(robot->spec(), values.run, result));
  if (record) record->finish();
  return result.end == FollowerEnd::requested && !result.robot_failed() ? 0 : 1;
}

}  // namespace
}  // namespace feltwire

int main(int argc, char** argv) {
  using namespace feltwire;
  FollowerOptionValues values;
  CLI::App app{
      "feltwire-follower: lets a robot follow a hand (docs/teleoperation.md). The robot is "
      "simulated, or another\nprogram drives it (docs/followers.md). This is not a safety-rated "
      "system."};
  add_options(app, values);
  Rivals rivals = exclusive({"surroundings", "arm", "socket"});
  rivals.push_back({"socket", "at"});  // --at sets the position of simulated robots only
  for (const Rival& rival : credential_rivals()) rivals.push_back(rival);
  ConfigFile config;
  try {
    read_environment(app, argc, argv, {.program = "follower", .shared = credential_variables()},
                     rivals);
    config = given_config(
        app, argc, argv, {},
        files_in_folder({"arm", "ca", "certificate", "fingerprint-file", "key", "prior", "record",
                         "report", "socket", "surroundings", "token-file"}),
        {}, true);
    parse_words(app, words_with_config(app, argc, argv, config, rivals, true));
    return follow(values);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return refuse((config.entries.empty() ? error.what() : config.located(error.what())) +
                      advice(error, app) + "; see --help",
                  kBadUsage);
  } catch (const std::invalid_argument& error) {
    return refuse(config.located(error.what()), kBadUsage);
  } catch (const std::exception& error) {
    return refuse(error.what(), 1);
  }
}
