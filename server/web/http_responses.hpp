#pragma once
// The answers to requests at the live page's port. It has no socket.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/http_request.hpp"
#include "server/web/page_assets.hpp"
#include "server/web/sent_file.hpp"
#include "server/web/shared_bytes.hpp"
#include "server/web/view_tickets.hpp"

namespace feltwire::web {

/// The path of the WebSocket.
inline constexpr std::string_view kLivePath = "/live";
/// Its subprotocol.
inline constexpr std::string_view kLiveProtocol = "feltwire.live.v1";
/// The path of the WebSocket for viewers of the Foxglove protocol, and the path for a ticket.
inline constexpr std::string_view kFoxglovePath = "/foxglove", kTicketPath = "/ticket";
/// The path of a recording of the server, with a ticket for it.
inline constexpr std::string_view kRecordingPath = "/recording";

/// The content of the site and the rules for its requests.
struct Site {
  std::span<const PageAsset> page;
  std::span<const std::string> names;  // host names that requests may use, besides IP addresses
  bool secure = false;         // by TLS; otherwise only requests from this machine are allowed
  bool counters_only = false;  // only `/metrics`, `/health` and `/ready` are answered
  /// Makes the answer to `/metrics`; empty: there is no such page.
  std::function<std::string()> metrics = {};
  /// The name of a scene that cannot be seen now, which makes `/ready` fail; nothing: all are seen.
  /// An empty name: the token (empty: none was shown) opens none of those that are not seen.
  std::function<std::optional<std::string>(std::string_view token)> hidden_scene = {};
  /// Whether a text is a valid token. Used for `/ticket`, and for `/metrics` if the site is secure.
  std::function<bool(std::string_view token)> opens = {};
  /// Returns a ticket for a scene that the token opens; empty if it opens none of that name.
  std::function<std::optional<Secret>(std::string_view token, std::string_view scene)> mint = {};
  /// Counts a wrong token or ticket of whoever asks. False: there were too many. Empty: no limit.
  std::function<bool()> may_try_again = {};
  /// Redeems a ticket, which is void from then on.
  std::function<std::optional<ViewTicket>(std::string_view ticket)> redeem = {};
  /// Redeems a ticket of a recording, which is void from then on: its file. Empty: there are no
  /// recordings.
  std::function<std::optional<std::filesystem::path>(std::string_view ticket)> redeem_download = {};
};

/// An answer as bytes. `upgraded`: the connection becomes a WebSocket; otherwise it ends.
struct HttpResponse {
  std::vector<std::uint8_t> bytes;
  bool upgraded = false;
  std::optional<ViewTicket> ticket = {};  // the viewer's ticket
  SharedBytes body = {};                  // after the bytes: a file of the page
  std::shared_ptr<SentFile> file = {};    // after the bytes: a recording; null: none
};

/// Answers a request; null: a malformed one.
///
/// A request must name this server as an IP address or localhost, or by one of the site's names. So
/// a page of another site whose name was directed here (DNS rebinding) is refused. The page's
/// WebSocket must be opened by a page of this server (Origin). Where this server speaks HTTP, a
/// page over HTTPS counts too if it has one of the site's names: a proxy speaks TLS for it. That of
/// the Foxglove protocol may be opened by any page or program with a ticket, because no browser
/// adds one by itself.
HttpResponse http_response(const HttpRequest* request, const Site& site);

}  // namespace feltwire::web
