#pragma once
// What a request to the live page's port is answered. No socket.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/http_request.hpp"
#include "server/web/page_assets.hpp"

namespace feltwire::web {

/// The path of the WebSocket.
inline constexpr std::string_view kLivePath = "/live";
/// Its subprotocol.
inline constexpr std::string_view kLiveProtocol = "feltwire.live.v1";

/// What is asked for, and by which rules.
struct Site {
  std::span<const PageAsset> page;
  std::span<const std::string> names;  // that it may be asked by, beside IP addresses
  bool secure = false;                 // by TLS; else it is asked on this machine alone
  /// What `/metrics` answers; empty: there is none.
  std::function<std::string()> metrics = {};
  /// Whether a text is a good token. Asked for `/metrics` where the site is secure.
  std::function<bool(std::string_view token)> opens = {};
};

/// An answer as bytes. `upgraded`: the connection is a WebSocket from then on; else it ends.
struct Answer {
  std::vector<std::uint8_t> bytes;
  bool upgraded = false;
};

/// Answers a request; null: a malformed one.
///
/// A request must name this server as an IP address or localhost, or by one of the site's names: a
/// page of another site whose name was made to lead here (DNS rebinding) does not. A WebSocket must
/// be opened by a page of this very server (Origin).
Answer answer(const HttpRequest* request, const Site& site);

}  // namespace feltwire::web
