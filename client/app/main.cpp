// feltwire-client: joins a scene with one hand.

#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/app/admin_command.hpp"
#include "client/app/admin_requests.hpp"
#include "client/app/client_options.hpp"
#include "client/app/devices_command.hpp"
#include "client/app/identify_command.hpp"
#include "client/app/open_client.hpp"
#include "client/run/check.hpp"
#include "client/run/run_client.hpp"
#include "core/base/visible_text.hpp"
#include "protocol/command_line/command_error.hpp"

namespace feltwire {
namespace {

std::unique_ptr<Device> open_device(ClientOptions& options) {
  OpenedDevice opened = options.driver->open(options.device);
  for (const std::string& note : opened.notes)
    std::fprintf(stderr, "feltwire-client: note: %s\n", visible(note).c_str());
  return hand_device(std::move(opened), options);
}

int list(const ServerAccess& server) {
  std::printf("%s", scene_table(server.endpoint, list_scenes(server, kControlTimeout)).c_str());
  return 0;
}

/// Returns the name of the server's first scene, which is the default scene.
std::string first_scene(const ServerAccess& server) {
  const auto scenes = list_scenes(server, kControlTimeout);
  if (scenes.empty()) throw std::runtime_error("the server has no scene that this token opens");
  return scenes.front().name;
}

/// Runs a session and checks its measured values (option --check). Returns 0 if no check fails.
int check(ClientOptions& options) {
  if (options.scene.empty()) options.scene = first_scene(options.server);
  std::vector<CheckResult> results;
  options.hooks.on_end = [&](const RunFigures& run) {
    results = judge(run, machine_facts(run.server));
    return json(results);
  };
  options.hooks.on_exit = [&](int ran) {
    std::printf("%s", table(results).c_str());
    return ran == 0 && worst(results) != Verdict::fail ? 0 : 1;
  };
  auto device = open_device(options);
  return run_client(std::move(device), options);
}

int run(ClientOptions options) {
  if (options.list) return list(options.server);
  options.hooks.open_port = port_opener(options);
  if (options.check) return check(options);
  auto device = open_device(options);
  return run_client(std::move(device), options);
}

}  // namespace
}  // namespace feltwire

int main(int argc, char** argv) {
  feltwire::forbid_core_dumps();
  feltwire::end_without_random_numbers();
  if (argc > 1 && std::string_view(argv[1]) == "admin")
    return feltwire::admin_command(argc - 1, argv + 1);
  if (argc > 1 && std::string_view(argv[1]) == "devices")
    return feltwire::devices_command(argc - 1, argv + 1);
  if (argc > 1 && std::string_view(argv[1]) == "identify")
    return feltwire::identify_command(argc - 1, argv + 1);
  try {
    const auto parsed = feltwire::parse_options(argc, argv);
    if (const int* code = std::get_if<int>(&parsed)) return *code;
    return feltwire::run(std::get<feltwire::ClientOptions>(parsed));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-client: %s\n", feltwire::printable_error(error.what()).c_str());
    return 1;
  }
}
