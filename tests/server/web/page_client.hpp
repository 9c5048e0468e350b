#pragma once
// A server with the live page, and the browser's end of its WebSocket.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "server/app/server.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/web/frames.hpp"

namespace feltwire::test {

inline ServerConfig with_page() {
  ServerConfig config = any_port();
  config.web = "0";
  return config;
}

/// The page's port at a server or a gateway.
template <class Site>
std::uint16_t page_port(const Site& site) {
  const std::string url = site.web_url();
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
}

inline std::vector<std::uint8_t> bytes(std::string_view text) { return {text.begin(), text.end()}; }

/// The browser's end of the WebSocket.
class Page {
 public:
  template <class Site>
  explicit Page(const Site& site) : Page(site, "/live", "feltwire.live.v1") {}
  template <class Site>
  Page(const Site& site, const std::string& token) : Page(site) {
    say(nlohmann::json{{"token", token}});
  }
  template <class Site>
  Page(const Site& site, const std::string& path, const std::string& protocol)
      : socket_(SOCK_STREAM, page_port(site)) {
    const std::string host = "127.0.0.1:" + std::to_string(page_port(site));
    socket_.send(bytes("GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nOrigin: http://" + host +
                       "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13"
                       "\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                       "Sec-WebSocket-Protocol: " +
                       protocol + "\r\n\r\n"));
    const std::string end = "\r\n\r\n";
    for (;;) {
      const auto found = std::search(input_.begin(), input_.end(), end.begin(), end.end());
      if (found != input_.end()) {
        head_.assign(input_.begin(), found);
        input_.erase(input_.begin(), found + 4);
        break;
      }
      if (!more()) break;
    }
  }

  const std::string& head() const { return head_; }
  void say(const nlohmann::json& message) { say_frame(1, message.dump()); }
  void say_frame(int opcode, std::string_view payload) {
    socket_.send(client_frame(opcode, payload));
  }

  /// The next frame; opcode 0 if the connection has ended.
  Frame next() {
    for (;;) {
      if (auto frame = take_frame(input_)) return *frame;
      if (!more()) return {};
    }
  }
  /// The next text of this type; no type if the connection ends first.
  nlohmann::json text(const std::string& type) {
    for (Frame frame = next(); frame.opcode != 0; frame = next())
      if (frame.opcode == 1)
        if (nlohmann::json said = nlohmann::json::parse(frame.text()); said["type"] == type)
          return said;
    return {};
  }
  std::vector<std::uint8_t> picture() { return binary(2); }
  std::vector<std::uint8_t> surfaces() { return binary(3); }
  /// The next binary message of this kind; empty if the connection ends first.
  std::vector<std::uint8_t> binary(std::uint8_t kind) {
    for (Frame frame = next(); frame.opcode != 0; frame = next())
      if (frame.opcode == 2 && !frame.payload.empty() && frame.payload[0] == kind)
        return frame.payload;
    return {};
  }
  Frame close() {
    for (Frame frame = next(); frame.opcode != 0; frame = next())
      if (frame.opcode == 8) return frame;
    return {};
  }

 private:
  bool more() {
    const auto came = socket_.receive(65536);
    input_.insert(input_.end(), came.begin(), came.end());
    return !came.empty();
  }
  RawSocket socket_;
  std::vector<std::uint8_t> input_;
  std::string head_;
};

}  // namespace feltwire::test
