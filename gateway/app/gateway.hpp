#pragma once
// The gateway as a value; programs and tests start it in the same way. It observes a server, and
// serves the live page of the observed scenes.

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
  ServerAccess server;                        // the observed server
  std::vector<std::filesystem::path> scenes;  // files of the server's scenes, at least one
  std::string web = "6760";                   // of the page: "PORT" or "ADDRESS:PORT"
  std::vector<std::string> web_names;         // host names that browsers may use for the page
  std::string log_level = "info";
  std::string log_format = "text";  // or json
};

class Gateway {
 public:
  /// Loads the scenes, binds the port and starts the threads. It tries for ever to reach a server
  /// that is away. Throws FileError, std::invalid_argument, std::runtime_error or LastingError,
  /// each with one clear line, also if the server refuses the gateway or does not have these
  /// scenes.
  explicit Gateway(const GatewayConfig& config);
  /// Uses the given scenes and identity instead of reading those of the configuration.
  Gateway(const GatewayConfig& config, std::vector<Scene> scenes, Security security);
  /// Stops the gateway.
  ~Gateway();
  Gateway(Gateway&&) noexcept;
  Gateway& operator=(Gateway&&) noexcept;

  /// The page's address: "http://127.0.0.1:6760/".
  std::string web_url() const;

  /// Reads the scenes' files and the page's certificate again; blocks. An error is logged, and that
  /// scene, or the certificate, stays unchanged.
  void reload();

  /// Ends connections, leaves the server and joins all threads. May be called again.
  void stop();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace feltwire
