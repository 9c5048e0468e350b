#pragma once
// The gateway as a value: programs and tests start it alike. It looks on at a server as an
// observer, and serves the live page of what it sees.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/transport/control_client.hpp"
#include "core/scene/scene.hpp"
#include "server/access/security.hpp"

namespace feltwire {

/// SecurityOptions: certificate, key and tokens of the gateway's own page; its address is that of
/// `web`.
struct GatewayConfig : SecurityOptions {
  ServerAccess server;                        // to look on at
  std::vector<std::filesystem::path> scenes;  // files of the server's scenes, at least one
  std::string web = "6760";                   // of the page: "PORT" or "ADDRESS:PORT"
  std::vector<std::string> web_names;         // of hosts that browsers may ask for the page by
  std::string log_level = "info";
};

class Gateway {
 public:
  /// Loads the scenes, binds the port and starts the threads. A server that cannot be reached is
  /// looked for for ever. Throws FileError, std::invalid_argument, std::runtime_error or
  /// LastingError, each one clear line: also where the server is there and does not let the gateway
  /// in, or has not these scenes.
  explicit Gateway(const GatewayConfig& config);
  /// The same with these at hand; the configuration's own are not read.
  Gateway(const GatewayConfig& config, std::vector<Scene> scenes, Security security);
  /// Stops.
  ~Gateway();
  Gateway(Gateway&&) noexcept;
  Gateway& operator=(Gateway&&) noexcept;

  /// The page's address: "http://127.0.0.1:6760/".
  std::string web_url() const;

  /// Reads the scenes' files anew; blocks. What is wrong is logged, and that scene stays as it was.
  void reload();

  /// Ends connections, leaves the server and joins all threads. May be called again.
  void stop();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace feltwire
