#include "server/app/server_program.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <asio/ip/address.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "core/base/pending_file.hpp"
#include "core/base/visible_text.hpp"
#include "core/scene/scene_cost_report.hpp"
#include "core/scene_file/load_scene.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/crypto/secret.hpp"
#include "protocol/net/ports.hpp"
#include "server/app/demo_hands.hpp"
#include "server/app/fleet_command.hpp"
#include "server/app/health.hpp"
#include "server/app/known_scenes.hpp"
#include "server/app/log_format.hpp"
#include "server/app/page_address.hpp"
#include "server/app/server.hpp"
#include "server/app/server_options.hpp"
#include "server/app/service_manager.hpp"
#include "server/app/signals.hpp"
#include "server/app/startup.hpp"
#include "server/app/subcommand.hpp"
#include "server/app/summary.hpp"
#include "server/app/token_command.hpp"
#include "server/scene/answer_time.hpp"
#include "server/scene/unreachable_objects.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kHealthTimeout{1500};
constexpr const char* kClient = "feltwire-client";

int fail(int status, const char* what) {
  std::fprintf(stderr, "feltwire-server: %s\n", printable_error(what).c_str());
  return status;
}

/// Returns the word as a shell reads it: in quotes if it has special characters.
std::string shell_word(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// Returns the path of the client in the folder of this program, or an empty path.
std::filesystem::path client_beside() {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  fs::path beside = self.parent_path() / kClient;
  return failed || !fs::exists(beside, failed) ? fs::path() : beside;
}

/// Returns the shell command of the client: its plain name if the shell finds the client of this
/// installation, else the path of the client in the folder of this program.
std::string client_program() {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path beside = client_beside();
  if (beside.empty()) return kClient;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path found = fs::path(folder) / kClient;
    if (folder.empty() || ::access(found.c_str(), X_OK) != 0) continue;
    if (fs::equivalent(found, beside, failed)) return kClient;
    break;  // the shell would start another client
  }
  return shell_word(beside.string());
}

/// Returns HOST:PORT of the control port from this machine.
std::string control_address(const ServerConfig& config, const Server& server) {
  const bool any = asio::ip::make_address(config.address).is_unspecified();
  return host_and_port(any ? "127.0.0.1" : config.address, server.control_port());
}

/// Returns the command line with which a client on this machine joins.
std::string join_line(const ServerConfig& config, const Server& server) {
  const auto token = local_token_file(config);
  const bool has_token = !token.empty() && std::filesystem::exists(token);
  return client_program() + " --connect " + control_address(config, server) + " --scene " +
         shell_word(server.scenes().front().scene) + " --fingerprint " +
         to_string(server.fingerprint()) + " --token-file " +
         (has_token ? shell_word(std::filesystem::absolute(token).string()) : "FILE");
}

void print_ready(const ServerConfig& config, const Server& server) {
  std::printf("fingerprint: %s\n", to_string(server.fingerprint()).c_str());
  std::printf("listening: control tcp %u", unsigned{server.control_port()});
  for (const auto& scene : server.scenes())
    std::printf(", scene %s udp %u", visible(scene.scene).c_str(), unsigned{scene.udp_port});
  std::printf("\njoin: %s\n", join_line(config, server).c_str());
  if (const std::string page = server.web_url(); !page.empty()) {
    std::printf("live page: %s%s\n", page.c_str(), token_for_page(config).c_str());
    if (const std::string admin = admin_token_for_page(config); !admin.empty())
      std::printf("as an admin: %s%s\n", page.c_str(), admin.c_str());
  }
  if (const std::string counters = server.metrics_url(); !counters.empty())
    std::printf("metrics: %s\n", counters.c_str());
  std::fflush(stdout);
}

/// Starts the hands of --demo. Returns none without it.
std::unique_ptr<DemoHands> start_demo(const ServerConfig& config, const Server& server) {
  if (!config.demo) return nullptr;
  DemoHandsSetup setup{.client = client_beside(),
                       .server = control_address(config, server),
                       .fingerprint = to_string(server.fingerprint()),
                       .token = local_token_file(config),
                       .logs = local_token_file(config).parent_path()};
  if (setup.client.empty())
    throw std::runtime_error(
        "--demo: there is no feltwire-client beside this program; install it there");
  for (const auto& scene : server.scenes()) setup.scenes.push_back(scene.scene);
  if (!std::filesystem::exists(setup.token))
    throw std::runtime_error(
        "--demo: its hands need " + setup.token.string() +
        ", which only a first start makes; make it with feltwire-server token add --client demo "
        "--scene '*' --role operator --expires never --state " +
        shell_word(setup.logs.string()) + " --out " + shell_word(setup.token.string()));
  auto hands = std::make_unique<DemoHands>(setup);
  std::printf("demo: two simulated hands in each scene; what they say: %s\n",
              visible((setup.logs / "demo-1.log").string()).c_str());
  std::fflush(stdout);
  return hands;
}

/// Reads the files of the configuration, and opens nothing. Throws FileError with the first that is
/// wrong.
int check_config(const ServerConfig& config) {
  std::vector<Scene> scenes;
  for (const auto& file : config.scenes) {
    scenes.push_back(load_scene(file));
    for (const std::string& warning : scenes.back().warnings())
      std::fprintf(stderr, "%s\n", visible(file.string() + ": warning: " + warning).c_str());
  }
  check_scene_names(scenes);
  check_security(config);
  std::printf("the configuration is right, %zu scene(s)\n", config.scenes.size());
  return 0;
}

/// Serves until SIGINT or SIGTERM. Precondition: every thread blocks these signals, SIGUSR1, SIGHUP
/// and SIGCHLD. Returns false if a thread still hangs because a file that it reads does not answer.
/// `demo`: the hands of --demo, or null.
bool serve(Server& server, const sigset_t& signals, const std::string& summary, DemoHands* demo) {
  const auto count = [&] {
    if (!summary.empty()) write_summary(summary, server.summary(), server.control_summary());
  };
  const auto write_all = [&] {
    server.write_flight_records();
    count();
  };
  const auto reload = [&] {
    spdlog::info("SIGHUP: all scenes and the certificate are read again");
    server.reload([](const std::vector<std::string>& all) {
      for (const std::string& wrong : all) spdlog::error("{}; the scene stays as it was", wrong);
    });
    try {
      server.renew_certificate();
    } catch (const std::exception& error) {
      spdlog::error("{}; the certificate stays as it was", error.what());
    }
  };
  const auto look_at_hands = [&] {
    if (demo == nullptr) return;
    for (const std::string& ended : demo->ended()) spdlog::warn("demo: {}", ended);
  };
  const int signal = wait_for_end(signals, {write_all, reload, look_at_hands});
  spdlog::info("{}: saying goodbye", signal == SIGINT ? "interrupted" : "terminated");
  tell_service_manager("STOPPING=1");
  if (demo != nullptr) demo->end();
  server.leave_fleet();
  const bool ended = server.stop();
  try {
    count();
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
  }
  std::fputs(visible_lines(text(server.summary()) + text(server.control_summary())).c_str(),
             stdout);
  return ended;
}

/// Ends the process without waiting for other threads, which may hang forever.
[[noreturn]] void leave_now() {
  spdlog::warn("a scene's file gives no answer: leaving without it");
  std::fflush(stdout);
  std::_Exit(0);
}

}  // namespace

int server_program(int argc, char** argv, const web::MakePageHands& make_page_hands) {
  forbid_core_dumps();
  end_without_random_numbers();
  if (argc > 1 && std::string_view(argv[1]) == "token") return token_command(argc - 1, argv + 1);
  if (argc > 1 && std::string_view(argv[1]) == "fleet") return fleet_command(argc - 1, argv + 1);
  try {
    const ServerTask asked = server_task(argc, argv);
    const ServerConfig& config = asked.config;
    if (!asked.explain.empty()) {
      const Scene scene = load_scene(asked.explain);
      std::vector<std::string> warnings = scene.warnings();
      if (auto far = warning_of_unreachable_objects(scene)) warnings.push_back(*far);
      if (auto slow = warning_of_slow_answers(scene)) warnings.push_back(*slow);
      for (const std::string& warning : warnings)
        std::fprintf(stderr, "%s\n", visible(asked.explain + ": " + warning).c_str());
      std::fputs(visible_lines(describe_costs(scene)).c_str(), stdout);
      return 0;
    }
    if (asked.health) {
      check_health(config.address, config.port, kHealthTimeout);
      return 0;
    }
    validate(config);
    if (asked.check) return check_config(config);
    open_log("feltwire-server", config.log.level, config.log.format);
    // Block signals before any thread starts, so that only this thread receives them.
    const sigset_t signals = block_signals();

    StartEnded start_ended;
    std::optional<Server> server = start_server(config, start_ended, make_page_hands);
    if (!server) {
      spdlog::info("{} before it served",
                   start_ended.signal == SIGINT ? "interrupted" : "terminated");
      if (start_ended.left_behind) leave_now();
      return 0;
    }
    // Write the summary once now, so that the user learns of an unwritable file at the start.
    if (!asked.summary.empty()) {
      remove_leftovers(asked.summary);
      write_summary(asked.summary, server->summary(), server->control_summary());
    }
    std::vector<std::string> names;
    for (const auto& scene : server->scenes()) names.push_back(scene.scene);
    note_scenes(config, names);
    print_ready(config, *server);
    const auto demo = start_demo(config, *server);
    tell_service_manager("READY=1");
    if (!serve(*server, signals, asked.summary, demo.get())) leave_now();
    return 0;
  } catch (const std::invalid_argument& error) {
    return fail(kBadUsage, error.what());
  } catch (const std::bad_alloc&) {
    return fail(kCannotRun,
                "there is not enough memory; free some, or raise the limit (ulimit -v)");
  } catch (const std::exception& error) {
    return fail(kCannotRun, error.what());
  }
}

}  // namespace feltwire
