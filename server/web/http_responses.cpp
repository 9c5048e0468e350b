#include "server/web/http_responses.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>
#include <utility>

#include "server/web/authority.hpp"
#include "server/web/query.hpp"

namespace feltwire::web {
namespace {

struct Status {
  int code;
  const char* text;
};
constexpr Status kOk{200, "OK"}, kNotModified{304, "Not Modified"}, kBad{400, "Bad Request"},
    kUnauthorized{401, "Unauthorized"}, kForbidden{403, "Forbidden"}, kNotFound{404, "Not Found"},
    kNotAllowed{405, "Method Not Allowed"}, kUpgrade{426, "Upgrade Required"},
    kTooMany{429, "Too Many Requests"}, kUnavailable{503, "Service Unavailable"};

// The page may load only this server's scripts, styles, pictures and connections. No other page may
// show it in a frame.
constexpr std::string_view kPolicy =
    "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n";

// Two names of one protocol: present versions of Foxglove ask for the first, older ones for the
// second.
constexpr std::array<std::string_view, 2> kFoxgloveProtocols = {"foxglove.sdk.v1",
                                                                "foxglove.websocket.v1"};

constexpr std::string_view kNoStore = "Cache-Control: no-store\r\n";

std::vector<std::uint8_t> bytes_of(const std::string& head, std::string_view body = {}) {
  std::vector<std::uint8_t> bytes(head.begin(), head.end());
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

std::string head(const Status& status, std::string_view type, std::size_t length,
                 std::string_view more = {}) {
  std::string text = "HTTP/1.1 " + std::to_string(status.code) + " " + status.text + "\r\n";
  text += "Content-Type: " + std::string(type) + "\r\n";
  text += "Content-Length: " + std::to_string(length) + "\r\n";
  text += "Connection: close\r\n";
  text += kPolicy;
  text += more;
  return text + "\r\n";
}

HttpResponse plain(const Status& status, const std::string& text, std::string_view more = {}) {
  return {bytes_of(head(status, "text/plain; charset=utf-8", text.size(), more), text), false};
}

/// Counts a wrong token or ticket. Returns a refusal if there were too many; else empty.
std::optional<HttpResponse> too_many(const Site& site) {
  if (!site.may_try_again || site.may_try_again()) return std::nullopt;
  return plain(kTooMany, "too many wrong tokens from this address or its network; wait a minute\n",
               "Retry-After: 60\r\n");
}

/// Returns whether the host is one of `names`, which the owner of the server has configured.
bool is_named(const Authority& asked, std::span<const std::string> names) {
  return std::ranges::any_of(names, [&](const std::string& name) {
    const auto known = parse_authority(name);
    return known && known->host == asked.host;
  });
}
bool is_named(std::string_view authority, std::span<const std::string> names) {
  const auto asked = parse_authority(authority);
  return asked && is_named(*asked, names);
}

bool is_ours(std::string_view authority, std::span<const std::string> names) {
  const auto asked = parse_authority(authority);
  return asked && (asked->is_address || asked->host == "localhost" || is_named(*asked, names));
}

/// Returns the authority as browsers write it: without `port`, the default port of its scheme.
std::string_view without_port(std::string_view authority, std::string_view port) {
  if (authority.ends_with(port)) authority.remove_suffix(port.size());
  return authority;
}

/// Returns whether the page that opens the WebSocket comes from this server (header Origin). A page
/// under one of the site's names may use HTTPS although this server uses HTTP: then a proxy on this
/// machine adds TLS. No page of another machine can have that name.
bool same_origin(const HttpRequest& request, const std::string& authority, const Site& site) {
  const std::string* header = request.header("origin");
  if (header == nullptr) return false;
  const std::string_view origin = *header;
  const auto is = [&](std::string_view scheme, std::string_view port) {
    return origin.starts_with(scheme) &&
           without_port(origin.substr(scheme.size()), port) == without_port(authority, port);
  };
  if (is("https://", ":443")) return site.secure || is_named(authority, site.names);
  return !site.secure && is("http://", ":80");
}

/// Returns whether the client's own connection uses TLS: to this server, or to a proxy that says so
/// in X-Forwarded-Proto.
bool by_tls(const HttpRequest& request, const Site& site) {
  const std::string* forwarded = request.header("x-forwarded-proto");
  return site.secure || (forwarded != nullptr && *forwarded == "https");
}

/// Returns the folder of the client's host in which a proxy serves this site, as the proxy says in
/// X-Forwarded-Prefix, without '/' at its end. Empty: the site has the whole host.
std::string_view folder_of(const HttpRequest& request) {
  const std::string* prefix = request.header("x-forwarded-prefix");
  if (prefix == nullptr || !is_plain_path(*prefix)) return {};
  return std::string_view(*prefix).substr(0, prefix->find_last_not_of('/') + 1);
}

/// Returns a refusal if the request for a WebSocket is malformed; else empty.
std::optional<HttpResponse> refuse_upgrade(const HttpRequest& request) {
  const std::string* upgrade = request.header("upgrade");
  const std::string* connection = request.header("connection");
  const std::string* version = request.header("sec-websocket-version");
  if (upgrade == nullptr || connection == nullptr || !has_member(*upgrade, "websocket") ||
      !has_member(*connection, "upgrade"))
    return plain(kUpgrade, "this is a WebSocket\n", "Upgrade: websocket\r\n");
  if (version == nullptr || *version != "13")
    return plain(kUpgrade, "WebSocket version 13 is spoken here\n",
                 "Sec-WebSocket-Version: 13\r\n");
  return std::nullopt;
}

/// Returns the answer that opens the WebSocket, with the first of `protocols` that the client asks
/// for. Returns a refusal if it asks for none of them.
HttpResponse switch_protocols(const HttpRequest& request,
                              std::span<const std::string_view> protocols) {
  const std::string* asked = request.header("sec-websocket-protocol");
  const auto chosen = std::ranges::find_if(protocols, [&](std::string_view protocol) {
    return asked != nullptr && has_member(*asked, protocol);
  });
  if (chosen == protocols.end())
    return plain(kBad, "the subprotocol is " + std::string(protocols.front()) + "\n");
  const std::string* key = request.header("sec-websocket-key");
  const auto accept = websocket_accept(key == nullptr ? std::string_view{} : *key);
  if (!accept) return plain(kBad, "Sec-WebSocket-Key is not 16 bytes in base64\n");
  return {bytes_of("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: "
                   "Upgrade\r\nSec-WebSocket-Accept: " +
                   *accept + "\r\nSec-WebSocket-Protocol: " + std::string(*chosen) + "\r\n\r\n"),
          true};
}

HttpResponse live(const HttpRequest& request, const std::string& authority, const Site& site) {
  if (auto refused = refuse_upgrade(request)) return *refused;
  if (!same_origin(request, authority, site))
    return plain(kForbidden, "a page of another site may not look on\n");
  return switch_protocols(request, {&kLiveProtocol, 1});
}

/// Opens the WebSocket for the Foxglove protocol. Redeems the ticket last, so that another error
/// does not use it up.
HttpResponse foxglove(const HttpRequest& request, const Site& site) {
  if (auto refused = refuse_upgrade(request)) return *refused;
  HttpResponse accepted = switch_protocols(request, kFoxgloveProtocols);
  if (!accepted.upgraded) return accepted;
  const auto shown = query_value(request.query, "ticket");
  if (shown && site.redeem) accepted.ticket = site.redeem(*shown);
  if (accepted.ticket) return accepted;
  if (auto refused = too_many(site)) return *std::move(refused);
  return plain(kForbidden,
               "the ticket is not good: each is for one connection, within a minute; take a new "
               "one\n");
}

/// Returns the token of the header `Authorization: Bearer fw_...`; empty if there is none.
std::string_view bearer(const HttpRequest& request) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string* shown = request.header("authorization");
  if (shown == nullptr || !shown->starts_with(kScheme)) return {};
  return std::string_view(*shown).substr(kScheme.size());
}

/// Refuses a request without a valid token. A request without any token does not count as a guess.
HttpResponse unauthorized(const HttpRequest& request, const Site& site) {
  if (!bearer(request).empty())
    if (auto refused = too_many(site)) return *std::move(refused);
  return plain(kUnauthorized, "show a token: Authorization: Bearer fw_...\n",
               "WWW-Authenticate: Bearer\r\n");
}

/// Answers a request for a ticket. It needs a token even on this machine, because a ticket opens a
/// scene.
HttpResponse ticket(const HttpRequest& request, const std::string& authority, const Site& site) {
  const std::string_view token = bearer(request);
  if (!site.opens || !site.mint || !site.opens(token)) return unauthorized(request, site);
  const auto minted = site.mint(token, query_value(request.query, "scene").value_or(""));
  if (!minted)
    return plain(kNotFound, "there is no such scene, or the token does not open it\n", kNoStore);
  return plain(kOk,
               (by_tls(request, site) ? "wss://" : "ws://") + authority +
                   std::string(folder_of(request)) + std::string(kFoxglovePath) +
                   "?ticket=" + std::string(minted->text()) + "\n",
               kNoStore);
}

/// Sends a recording. Redeems the ticket last, so that another error does not use it up.
HttpResponse recording(const HttpRequest& request, const Site& site) {
  if (request.method != "GET")
    return plain(kNotAllowed, "only GET is answered\n", "Allow: GET\r\n");
  const auto shown = query_value(request.query, "ticket");
  const auto path = shown && site.redeem_download ? site.redeem_download(*shown) : std::nullopt;
  if (!path) {
    if (auto refused = too_many(site)) return *std::move(refused);
    return plain(kForbidden,
                 "the ticket is not good: each is for one download, within a minute; take a new "
                 "one on the page\n",
                 kNoStore);
  }
  HttpResponse answer;
  try {
    answer.file = std::make_shared<SentFile>(*path);
  } catch (const std::system_error&) {
    return plain(kNotFound, "the recording is there no more\n", kNoStore);
  }
  // The server has made the name of letters, digits, '-', '_' and '.'.
  answer.bytes = bytes_of(head(kOk, "application/octet-stream", answer.file->size(),
                               "Content-Disposition: attachment; filename=\"" +
                                   path->filename().string() + "\"\r\n" + std::string(kNoStore)));
  return answer;
}

HttpResponse asset(const HttpRequest& request, std::span<const PageAsset> page) {
  if (page.empty())
    return plain(kUnavailable,
                 "This server was built without the live page. Install the Debian packages nodejs "
                 "and npm, and build it again.\n");
  const auto found = std::ranges::find(page, std::string_view(request.path), &PageAsset::path);
  if (found == page.end()) return plain(kNotFound, "there is no such file\n");
  const std::string tag = "\"" + std::string(found->sha256) + "\"";
  const std::string caching = "ETag: " + tag + "\r\nCache-Control: no-cache\r\n";
  if (const std::string* known = request.header("if-none-match"); known != nullptr && *known == tag)
    return {bytes_of(head(kNotModified, found->type, 0, caching)), false};
  HttpResponse answer;
  answer.bytes =
      bytes_of(head(kOk, found->type, found->gzip.size(), "Content-Encoding: gzip\r\n" + caching));
  // Point to the file, do not copy it: then a slow client costs no memory for the file.
  if (request.method == "GET") answer.body = SharedBytes::of_program(found->gzip);
  return answer;
}

/// Answers a request for the counters. If the page uses TLS, the request needs a token, because the
/// counters show the names of the scenes and their use.
HttpResponse metrics(const HttpRequest& request, const Site& site) {
  if (site.secure && (!site.opens || !site.opens(bearer(request))))
    return unauthorized(request, site);
  const std::string text = site.metrics();
  return {
      bytes_of(head(kOk, "text/plain; version=0.0.4; charset=utf-8", text.size(), kNoStore), text),
      false};
}

/// Answers whether all scenes can be seen. Anyone may ask. Only a client with a token for the scene
/// gets its name. Only viewers of the page get the reason, because it may name other machines.
HttpResponse ready(const HttpRequest& request, const Site& site) {
  const auto hidden = site.hidden_scene ? site.hidden_scene(bearer(request)) : std::nullopt;
  if (!hidden) return plain(kOk, "ok\n", kNoStore);
  return plain(kUnavailable,
               (hidden->empty() ? "a scene" : "scene " + *hidden) +
                   " is not seen: its server is away; the page and the log say why\n",
               kNoStore);
}

}  // namespace

HttpResponse http_response(const HttpRequest* request, const Site& site) {
  if (request == nullptr) return plain(kBad, "this is no HTTP/1.1 request that is read here\n");
  const std::string* authority = request->header("host");
  if (authority == nullptr || !is_ours(*authority, site.names))
    return plain(kForbidden, "this server is not known by that name; use its IP address\n");
  if (request->method != "GET" && request->method != "HEAD")
    return plain(kNotAllowed, "only GET and HEAD are answered\n", "Allow: GET, HEAD\r\n");
  if (site.counters_only && request->path != "/metrics" && request->path != "/health" &&
      request->path != "/ready")
    return plain(kNotFound, "this port has /metrics, /health and /ready alone\n");
  if (request->path == kLivePath) return live(*request, *authority, site);
  if (request->path == kFoxglovePath) return foxglove(*request, site);
  if (request->path == kRecordingPath) return recording(*request, site);
  if (request->path == kTicketPath) return ticket(*request, *authority, site);
  // This port answers only after all scenes are loaded and all ports are open.
  if (request->path == "/health") return plain(kOk, "ok\n", kNoStore);
  if (request->path == "/ready") return ready(*request, site);
  if (request->path == "/metrics" && site.metrics) return metrics(*request, site);
  return asset(*request, site.page);
}

}  // namespace feltwire::web
