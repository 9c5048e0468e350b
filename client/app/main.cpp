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
#include "client/app/client_options.hpp"
#include "client/app/devices_command.hpp"
#include "client/app/identify_command.hpp"
#include "client/emulated_link/emulated_port.hpp"
#include "client/run/check.hpp"
#include "client/run/run_client.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kLinkRoom = 1 << 13;  // capacity in datagrams: 0.8 s at 10 kHz

std::unique_ptr<Device> open_device(ClientOptions& options) {
  OpenedDevice opened = options.driver->open(options.device);
  for (const std::string& note : opened.notes)
    std::fprintf(stderr, "feltwire-client: note: %s\n", visible(note).c_str());
  options.true_energy = std::move(opened.true_energy);
  options.emergency = std::make_shared<EmergencyStop>();
  auto device = std::make_unique<ProtectedDevice>(std::move(opened.device), options.protection,
                                                  options.emergency);
  return std::make_unique<MappedDevice>(std::move(device), options.mapping);
}

/// Opens a UDP port to the scene. Adds an emulated link if the options have one.
std::unique_ptr<DatagramPort> open_port(const ClientOptions& options, const Address& scene) {
  auto line = open_udp_port(scene, options.dscp);
  if (!options.link) return line;
  return std::make_unique<EmulatedPort>(std::move(line), TwoWayLink(*options.link, 0, kLinkRoom));
}

int list(const ServerAccess& server) {
  std::printf("%-24s %8s %8s %8s\n", "scene", "port", "objects", "clients");
  for (const control::SceneEntry& scene : list_scenes(server, kControlTimeout))
    std::printf("%-24s %8u %8u %8u\n", visible(scene.name).c_str(),
                unsigned{server.endpoint.port} + scene.port_offset, scene.objects, scene.sessions);
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
  options.on_end = [&](const RunFigures& run) {
    results = judge(run, machine_facts(run.server));
    return json(results);
  };
  options.on_exit = [&](int ran) {
    std::printf("%s", table(results).c_str());
    return ran == 0 && worst(results) != Verdict::fail ? 0 : 1;
  };
  auto device = open_device(options);
  return run_client(std::move(device), options);
}

int run(ClientOptions options) {
  if (options.list) return list(options.server);
  options.open_port = [&options](const Address& scene) { return open_port(options, scene); };
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
    std::fprintf(stderr, "feltwire-client: %s\n", feltwire::visible(error.what()).c_str());
    return 1;
  }
}
