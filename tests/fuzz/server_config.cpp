// Takes arbitrary text as a server's configuration. The result must be an error with its place, or
// a valid configuration.

#include "server/app/server_config.hpp"

#include "core/base/json_document.hpp"
#include "protocol/net/busy_poll.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  try {
    ServerConfig config = parse_config(fuzz::text(data, size), "server.json");
    fuzz::require(config.port >= 0 && config.port <= 65535, "the port is one");
    fuzz::require(config.silence_timeout > 0.0 && config.max_sessions_per_scene > 0,
                  "limits are above zero");
    fuzz::require(possible_busy_poll(config.busy_poll), "busy polling ends, or never does");
    if (config.scenes.empty()) config.scenes.emplace_back("scene.json");
    // Port 65535 leaves no port for a scene.
    if (config.port < 65535) validate(config);
  } catch (const FileError& error) {
    fuzz::require_place(error.what(), "server.json");
  }
  return 0;
}
