#pragma once
// A connection to the live page's port: a request and its answer, or a viewer.

#include <asio/steady_timer.hpp>
#include <memory>
#include <optional>
#include <string>

#include "server/web/connection_host.hpp"
#include "server/web/stream.hpp"

namespace feltwire::web {

/// It stores little for the other end, whatever that does: nothing is read while something waits to
/// be written, a viewer with more than kMostWaiting of answers and news ends, and data that all
/// viewers get are not copied.
class Connection : public Viewer, public std::enable_shared_from_this<Connection> {
 public:
  /// [bytes] that are read, and thrown away, of a connection that closes.
  static constexpr std::size_t kMostDiscarded = std::size_t{64} * 1024;

  /// `host` outlives the handlers of `stream`.
  Connection(ConnectionHost& host, ConnectionSlots::Id id, std::unique_ptr<Stream> stream,
             const asio::ip::address& address);

  const asio::ip::address& address() const { return address_; }
  void start();
  /// All exits: the server forgets the connection, and its last handler destroys it.
  void end() noexcept;

  void send(const std::string& text) override;
  void show_text(const SharedBytes& text) override;
  void show_binary(std::span<const std::uint8_t> head, const SharedBytes& data) override;
  void ping() override;
  bool ready() const override;
  void close(WebSocketClose code, std::string_view reason) override;
  void admitted() override;

 private:
  template <class Work>
  auto safely(Work work);
  void set_deadline(std::chrono::milliseconds patience);
  void read_head();
  void answer_head(std::size_t length);
  void become_viewer(HttpResponse accepted);
  void read_on();
  void take_messages(std::span<const std::uint8_t> bytes);
  void pump();
  void part();
  void write_last(HttpResponse last);
  void write_file(const std::shared_ptr<SentFile>& file);
  void discard();
  bool discards(std::size_t count);

  ConnectionHost& host_;
  const ConnectionSlots::Id id_;
  asio::ip::address address_;
  std::unique_ptr<Stream> stream_;
  asio::steady_timer deadline_;
  std::string head_;  // the received part
  std::unique_ptr<WebSocket> socket_;
  std::optional<ViewerHub::Id> seat_;
  std::size_t discarded_ = 0;  // [bytes]
  bool reading_ = false, taking_ = false, writing_ = false;
  bool stays_ = false, closing_ = false, overfull_ = false, ended_ = false;
};

}  // namespace feltwire::web
