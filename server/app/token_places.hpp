#pragma once
// The places of tokens: the file of a server, or the directory of a fleet.

#include <functional>
#include <memory>
#include <string>

#include "server/access/tokens.hpp"
#include "server/app/server_config.hpp"
#include "server/fleet/directory.hpp"

namespace feltwire {

/// Each function throws FileError or std::runtime_error with the remedy.
struct TokenPlace {
  std::function<void(const Token&)> add;
  /// Returns false if there is no such token.
  std::function<bool(const std::string& id)> revoke;
  std::function<Tokens()> list;
  std::string name;  // for an error
};

/// The token file of the server with this configuration.
TokenPlace file_of_tokens(const ServerConfig& config);

/// The directory of a fleet. Each host takes the change when it sees it, and keeps it.
TokenPlace fleet_of_tokens(const std::shared_ptr<Directory>& directory);

}  // namespace feltwire
