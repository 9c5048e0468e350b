#pragma once
// The files with a server's identity and its tokens.

#include <filesystem>
#include <string>

namespace feltwire {

struct SecurityOptions {
  std::string address = "127.0.0.1";  // address to listen on; a new certificate contains it
  /// Files that are not configured are those of the state folder.
  std::filesystem::path state, certificate, key, client_ca, tokens;
};

}  // namespace feltwire
