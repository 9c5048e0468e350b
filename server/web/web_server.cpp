#include "server/web/web_server.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <future>
#include <utility>

#include "protocol/net/clock.hpp"
#include "protocol/net/real_time.hpp"
#include "server/access/listening.hpp"
#include "server/web/connection.hpp"

namespace feltwire::web {
namespace {

using asio::ip::tcp;
constexpr std::chrono::microseconds kFrame{16'667};  // time between two pictures
constexpr std::chrono::milliseconds kLastWords{250};

std::optional<asio::ssl::context> tls_for(const asio::ip::address& address,
                                          const Identity& identity) {
  if (address.is_loopback()) return std::nullopt;
  return server_tls(identity);
}

}  // namespace

WebServer::WebServer(const WebOptions& options, const ViewerHub::Scenes& scenes, TokenFile tokens,
                     const Identity& identity)
    : options_(options),
      tls_(tls_for(options.address, identity)),
      hub_(io_, scenes, std::move(tokens), options.hands,
           {options.reload, options.write_flight, options.record}),
      strangers_(std::max<std::size_t>(1, options.max_connections / 2),
                 options.max_connections_per_network),
      known_(std::max<std::size_t>(1, options.max_connections - options.max_connections / 2),
             options.max_connections_per_network) {
  port_ = listen_on(acceptor_, {options.address, options.port},
                    options.counters_only ? "--metrics" : "--web");
}

WebServer::~WebServer() { stop(); }

void WebServer::start() {
  accept();
  thread_ = std::thread([this] { run(); });
}

void WebServer::stop() {
  if (!thread_.joinable()) return;
  asio::post(io_, [this] {
    std::error_code ignored;
    acceptor_.close(ignored);
    retry_.cancel();
    hub_.close_all();
    // Give the viewers time (kLastWords) to receive the reason.
    frame_.expires_after(kLastWords);
    frame_.async_wait([this](const std::error_code&) { end_all(); });
    leave_if_empty();
  });
  thread_.join();
}

void WebServer::renew(const Identity& identity) {
  asio::post(io_, [this, identity] {
    if (tls_) tls_ = server_tls(identity);
  });
}

ViewerHubCounters WebServer::counters_now() {
  std::promise<ViewerHubCounters> counted;
  asio::post(io_, [&] { counted.set_value(hub_.counters()); });
  return counted.get_future().get();
}

void WebServer::tell(std::size_t scene, std::optional<std::string> wrong) {
  asio::post(io_, [this, scene, wrong = std::move(wrong)] { hub_.tell(scene, wrong); });
}

void WebServer::end_all() {
  while (!connections_.empty()) {
    // This copy keeps the object alive, because end() removes the connection from the map.
    const std::shared_ptr<Connection> connection = connections_.begin()->second;
    connection->end();
  }
  io_.stop();
}

void WebServer::leave_if_empty() {
  if (!acceptor_.is_open() && connections_.empty()) io_.stop();
}

std::string WebServer::host() const {
  if (options_.address.is_unspecified()) return "127.0.0.1";
  const std::string text = options_.address.to_string();
  return options_.address.is_v6() ? "[" + text + "]" : text;
}

std::string WebServer::url() const {
  return (secure() ? "https://" : "http://") + host() + ":" + std::to_string(port_) + "/";
}

/// Runs the thread of the port. The handlers of a connection catch their own exceptions. An
/// exception of another handler is logged, and the server continues.
void WebServer::run() {
  constexpr std::chrono::milliseconds kPause{100};  // pause after an exception, against a busy loop
  give_way();                                       // lower priority than the scenes' threads
  for (bool ended = false; !ended;) {
    try {
      io_.run();
      ended = true;
    } catch (const std::exception& error) {
      spdlog::error("{}: {}; it goes on", log_name(), error.what());
      std::this_thread::sleep_for(kPause);
      if (acceptor_.is_open()) accept_later();
      showing_ = false;
      show();
    }
  }
}

void WebServer::accept() {
  acceptor_.async_wait(tcp::acceptor::wait_read, [this](const std::error_code& error) {
    if (error == asio::error::operation_aborted || !acceptor_.is_open()) return;
    if (error) return accept_later();
    take();
  });
}

/// Tries again after a pause, because a file descriptor may be free by then. Open connections
/// continue.
void WebServer::accept_later() {
  retry_.expires_after(std::chrono::milliseconds(100));
  retry_.async_wait([this](const std::error_code& cancelled) {
    if (!cancelled) accept();
  });
}

void WebServer::take() {
  std::error_code error;
  tcp::socket socket(io_);
  acceptor_.accept(socket, error);
  const bool gone = error == asio::error::would_block || error == asio::error::connection_aborted;
  if (error && !gone) return accept_later();
  accept();
  if (error) return;
  const asio::ip::address address = socket.remote_endpoint(error).address();
  if (error) return;
  socket.set_option(tcp::no_delay(true), error);
  const ConnectionSlots::Id id = next_id_++;
  const auto crowded_out =
      strangers_.take(id, network_of(address), ConnectionSlots::member_of(address));
  ConnectionHost& host = *this;
  const auto connection = std::make_shared<Connection>(
      host, id, make_stream(std::move(socket), tls_ ? &*tls_ : nullptr), address);
  connections_.emplace(id, connection);
  crowd_out(crowded_out);
  connection->start();
}

void WebServer::take_place(ConnectionSlots& half, ConnectionSlots::Id id) {
  const auto found = connections_.find(id);
  if (found == connections_.end()) return;
  const asio::ip::address& address = found->second->address();
  crowd_out(half.take(id, network_of(address), ConnectionSlots::member_of(address)));
}

void WebServer::crowd_out(std::optional<ConnectionSlots::Id> id) {
  if (!id) return;
  const auto found = connections_.find(*id);
  if (found == connections_.end()) return;
  // This copy keeps the object alive, because end() removes the connection from the map.
  const std::shared_ptr<Connection> connection = found->second;
  connection->end();
}

void WebServer::admitted(ConnectionSlots::Id id) {
  show();
  if (strangers_.leave(id)) take_place(known_, id);
}

/// Moves a connection that closes from known_ to strangers_, so that another viewer can use its
/// place.
void WebServer::parting(ConnectionSlots::Id id) {
  if (known_.leave(id)) take_place(strangers_, id);
}

void WebServer::ended(ConnectionSlots::Id id) noexcept {
  strangers_.leave(id);
  known_.leave(id);
  connections_.erase(id);
  leave_if_empty();
}

Site WebServer::site(const asio::ip::address& asked_from) {
  Site site{page_assets(), options_.names, secure()};
  site.counters_only = options_.counters_only;
  if (options_.metrics) site.metrics = [this] { return options_.metrics(hub_.counters()); };
  site.hidden_scene = [this](std::string_view token) { return hub_.hidden_scene(token); };
  site.opens = [this](std::string_view token) {
    hub_.tokens().refresh();
    return hub_.tokens().authenticate(token) != nullptr;
  };
  site.may_try_again = [this, asked_from] { return hub_.tokens().may_try_again(asked_from); };
  site.mint = [this](std::string_view token, std::string_view scene) {
    return hub_.mint_ticket(hub_.tokens().authenticate(token), scene);
  };
  site.redeem = [this](std::string_view ticket) { return hub_.redeem_ticket(ticket); };
  site.redeem_download = [this](std::string_view ticket) { return hub_.redeem_download(ticket); };
  return site;
}

/// Sends a picture to the viewers every kFrame while there are viewers.
void WebServer::show() {
  if (showing_ || !acceptor_.is_open()) return;
  showing_ = true;
  frame_.expires_after(kFrame);
  frame_.async_wait([this](const std::error_code& cancelled) {
    showing_ = false;
    if (cancelled || hub_.empty()) return;
    hub_.tick(monotonic_now());
    show();
  });
}

}  // namespace feltwire::web
