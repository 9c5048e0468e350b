#pragma once
// One connection to the live page's port: a request and its answer, or a viewer.

#include <asio/steady_timer.hpp>
#include <memory>
#include <string>

#include "server/access/places.hpp"
#include "server/web/stream.hpp"
#include "server/web/web_server.hpp"

namespace feltwire::web {

class WebServer::Connection : public Viewer, public std::enable_shared_from_this<Connection> {
 public:
  Connection(WebServer& server, Places::Id id, std::unique_ptr<Stream> stream,
             const asio::ip::address& address);

  void start();
  /// All exits: the server forgets the connection, and its last handler destroys it.
  void end() noexcept;

  void send(const std::string& text) override;
  void send(const Bytes& binary) override;
  bool ready() const override;
  void close(WebSocketClose code, std::string_view reason) override;
  void admitted() override;

 private:
  template <class Work>
  auto safely(Work work);
  void set_deadline(std::chrono::milliseconds patience);
  void read_head();
  void answer_head(std::size_t length);
  void become_viewer(Answer accepted);
  void read_messages();
  void take_messages(std::span<const std::uint8_t> bytes);
  void pump();
  void write_last(std::vector<std::uint8_t> bytes);
  void discard();

  WebServer& server_;
  const Places::Id id_;
  asio::ip::address address_;
  std::unique_ptr<Stream> stream_;
  asio::steady_timer deadline_;
  std::string head_;  // the received part
  std::unique_ptr<WebSocket> socket_;
  std::optional<Audience::Id> seat_;
  bool writing_ = false, stays_ = false, closing_ = false, ended_ = false;
};

}  // namespace feltwire::web
