// Takes arbitrary bytes on the live page's port: a request head or WebSocket frames. Answers must
// follow the rules, and accepted values must be within their limits.

#include "server/web/foxglove_messages.hpp"
#include "server/web/http_responses.hpp"
#include "server/web/viewer_message.hpp"
#include "server/web/websocket.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr std::size_t kMostMessage = 512;

void read_head(std::string_view text) {
  const auto length = http_head_length(text);
  const auto request = parse_http_head(text.substr(0, length ? *length : text.size()));
  const std::string ticket = "good";
  web::Site site;
  site.redeem = [&](std::string_view shown) {
    return shown == ticket ? std::optional(web::ViewTicket{"id", "room"}) : std::nullopt;
  };
  site.opens = [&](std::string_view token) { return token == ticket; };
  site.mint = [&](std::string_view, std::string_view) { return Secret(ticket); };
  const web::HttpResponse answer = web::http_response(request ? &*request : nullptr, site);
  const std::string said(answer.bytes.begin(), answer.bytes.end());
  require(said.starts_with("HTTP/1.1 "), "every request has an answer");
  require(said.find("\r\n\r\n") != std::string::npos, "an answer's head ends");
  if (!request) {
    require(said.starts_with("HTTP/1.1 400 "), "a malformed request is refused");
    return;
  }
  require(request->path.starts_with('/'), "a path begins with a slash");
  require(request->path.find("..") == std::string::npos, "a path leads to no other folder");
  if (answer.upgraded && answer.ticket) {
    require(request->path == "/foxglove", "a ticket opens one path");
    require(request->query.find("ticket=") != std::string::npos, "a ticket was shown");
  } else if (answer.upgraded) {
    const std::string* origin = request->header("origin");
    require(origin != nullptr && origin->ends_with(*request->header("host")),
            "only a page of this server opens a WebSocket");
  }
}

void read_frames(Input& input) {
  WebSocket socket(kMostMessage, [](std::string_view message) {
    require(message.size() <= kMostMessage, "a message is within its limit");
    web::parse_viewer_message(message);
    const auto request = web::parse_foxglove_request(message);
    require(!request || !request->operation.empty(), "a request has an operation");
  });
  while (!input.empty()) {
    const Bytes piece = input.bytes(1u + input.byte() % 64u);
    if (!socket.receive(piece)) return;
    socket.take_output();
    if (socket.closed()) return;
  }
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  fuzz::Input input(data, size);
  if (input.coin())
    fuzz::read_frames(input);
  else
    fuzz::read_head(fuzz::text(data + (size > 0 ? 1 : 0), size > 0 ? size - 1 : 0));
  return 0;
}
