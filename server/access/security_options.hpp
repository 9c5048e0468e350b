#pragma once
// Which files a server takes its identity and its tokens from.

#include <filesystem>
#include <string>

namespace feltwire {

struct SecurityOptions {
  std::string address = "127.0.0.1";  // to listen on; a certificate that is made names it
  /// Where not named, certificate, key and tokens are the state folder's.
  std::filesystem::path state, certificate, key, client_ca, tokens;
};

}  // namespace feltwire
