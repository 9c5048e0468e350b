#pragma once
// What a request to the live page's port is answered. No socket.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/http_request.hpp"
#include "server/web/page_assets.hpp"
#include "server/web/view_tickets.hpp"

namespace feltwire::web {

/// The path of the WebSocket.
inline constexpr std::string_view kLivePath = "/live";
/// Its subprotocol.
inline constexpr std::string_view kLiveProtocol = "feltwire.live.v1";
/// The path of the WebSocket for viewers of the Foxglove protocol, and where a ticket for it is
/// had.
inline constexpr std::string_view kFoxglovePath = "/foxglove", kTicketPath = "/ticket";

/// The content of the site and the rules for its requests.
struct Site {
  std::span<const PageAsset> page;
  std::span<const std::string> names;  // that it may be asked by, beside IP addresses
  bool secure = false;                 // by TLS; else it is asked on this machine alone
  /// Makes the answer to `/metrics`; empty: there is no such page.
  std::function<std::string()> metrics = {};
  /// Whether a text is a good token. Asked for `/ticket`, and for `/metrics` where the site is
  /// secure.
  std::function<bool(std::string_view token)> opens = {};
  /// A ticket for a scene that the token opens; nothing where it opens none of that name.
  std::function<std::optional<Secret>(std::string_view token, std::string_view scene)> mint = {};
  /// Redeems a ticket: it is void from then on.
  std::function<std::optional<ViewTicket>(std::string_view ticket)> redeem = {};
};

/// An answer as bytes. `upgraded`: the connection is a WebSocket from then on; else it ends.
struct Answer {
  std::vector<std::uint8_t> bytes;
  bool upgraded = false;
  std::optional<ViewTicket> ticket = {};  // that the viewer has shown
};

/// Answers a request; null: a malformed one.
///
/// A request must name this server as an IP address or localhost, or by one of the site's names: a
/// page of another site whose name was made to lead here (DNS rebinding) does not. The page's
/// WebSocket must be opened by a page of this very server (Origin). That of the Foxglove protocol
/// may be opened by any page or program that shows a ticket: no browser adds one by itself.
Answer answer(const HttpRequest* request, const Site& site);

}  // namespace feltwire::web
