#pragma once
// The live page's port: HTTP for the page, WebSockets for its data, one thread.

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/access/connection_slots.hpp"
#include "server/access/identity.hpp"
#include "server/web/connection_host.hpp"
#include "server/web/http_responses.hpp"
#include "server/web/viewer_hub.hpp"

namespace feltwire::web {

class Connection;

struct WebOptions {
  asio::ip::address address;  // to listen on
  std::uint16_t port = 0;     // 0: the operating system chooses
  /// From connecting to a whole request, and from there to a valid token.
  std::chrono::milliseconds patience{5'000};
  /// Half of them for connections that have shown no valid token, half for viewers that have.
  std::size_t max_connections = 128;
  std::size_t max_connections_per_network = 64;  // of either half
  std::vector<std::string> names = {};  // host names that browsers may use, besides IP addresses
  bool counters_only = false;           // no page: only `/metrics`, `/health` and `/ready`
  PageHands* hands = nullptr;           // for viewers; outlives the server; null: none
  /// Makes the answer to `/metrics` (docs/live_page.md), on the page's thread; empty: there is no
  /// such page.
  std::function<std::string(const ViewerHubCounters& counters)> metrics = {};
  /// Reads a scene's file again (ViewerHub::Reload), on the page's thread; empty: not possible
  /// here.
  ViewerHub::Reload reload = {};
  /// Writes a flight record (ViewerHub::WriteFlight); empty: there is no flight recorder.
  ViewerHub::WriteFlight write_flight = {};
  /// Starts and stops recordings (ViewerHub::Record); empty: admins start none.
  ViewerHub::Record record = {};
};

class WebServer final : private ConnectionHost {
 public:
  /// Binds and listens. On a loopback address it uses HTTP, on all others HTTPS with the identity.
  /// Throws std::runtime_error with one line if it cannot. The scenes outlive this.
  WebServer(const WebOptions& options, const ViewerHub::Scenes& scenes, TokenFile tokens,
            const Identity& identity);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Starts the thread. Call once.
  void start();
  /// Ends all connections and joins the thread. May be called again.
  void stop();

  /// New connections get this certificate. From any thread.
  void renew(const Identity& identity);

  /// A load of a scene has ended (ViewerHub::tell). From any thread.
  void tell(std::size_t scene, std::optional<std::string> wrong);

  std::uint16_t port() const { return port_; }
  /// The page's address for a browser on this machine: "http://127.0.0.1:6760/".
  std::string url() const;
  /// The counters at this moment, for another thread while this server runs. Blocks until the
  /// page's thread has counted.
  ViewerHubCounters counters_now();

 private:
  asio::io_context& io() override { return io_; }
  ViewerHub& hub() override { return hub_; }
  Site site(const asio::ip::address& asked_from) override;
  std::string_view log_name() const override {
    return options_.counters_only ? "metrics" : "live page";
  }
  std::chrono::milliseconds patience() const override { return options_.patience; }
  void admitted(ConnectionSlots::Id id) override;
  void parting(ConnectionSlots::Id id) override;
  void ended(ConnectionSlots::Id id) noexcept override;
  bool secure() const { return tls_.has_value(); }
  std::string host() const;
  void run();
  void accept();
  void accept_later();
  void take();
  void take_place(ConnectionSlots& half, ConnectionSlots::Id id);
  void crowd_out(std::optional<ConnectionSlots::Id> id);
  void end_all();
  void leave_if_empty();
  void show();

  WebOptions options_;
  asio::io_context io_{1};
  std::optional<asio::ssl::context> tls_;
  asio::ip::tcp::acceptor acceptor_{io_};
  asio::steady_timer retry_{io_}, frame_{io_};
  ViewerHub hub_;
  std::map<ConnectionSlots::Id, std::shared_ptr<Connection>> connections_;
  // Each connection is in one. Those in known_ are admitted viewers.
  ConnectionSlots strangers_, known_;
  ConnectionSlots::Id next_id_ = 0;
  bool showing_ = false;  // the timer of pictures is running
  std::uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace feltwire::web
