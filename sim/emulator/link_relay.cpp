#include "sim/emulator/link_relay.hpp"

#include <algorithm>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <cerrno>
#include <map>
#include <span>
#include <stdexcept>
#include <vector>

#include "client/emulated_link/link_json.hpp"
#include "protocol/net/datagram_io.hpp"
#include "server/scene/scene_ports.hpp"
#include "sim/emulator/control_bridge.hpp"
#include "sim/emulator/relay_client.hpp"

namespace feltwire {
namespace {

using asio::ip::tcp;
using asio::ip::udp;
using Error = std::error_code;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxClients = 256;    // largest number of clients at a time
constexpr std::size_t kLinkRoom = 1 << 12;  // largest number of datagrams in transit, per direction
// A client that is silent for longer may be removed.
constexpr Nanoseconds kForgotten = std::chrono::seconds(60);

tcp::endpoint find(asio::io_context& io, const Endpoint& server) {
  Error error;
  const auto found = tcp::resolver(io).resolve(server.host, std::to_string(server.port), error);
  if (error)
    throw std::runtime_error("cannot find host '" + server.host + "': " + error.message() +
                             "; check the name in --to");
  return found.begin()->endpoint();
}

/// The address of the client of a datagram, and the relay's local address to which the client
/// sends.
struct DatagramAddresses {
  udp::endpoint client;
  LocalAddress local;
};

/// Calls receive_datagram() with the types of the relay.
ssize_t receive(udp::socket& socket, std::span<std::uint8_t> into, DatagramAddresses& way) {
  auto length = static_cast<socklen_t>(way.client.capacity());
  const ssize_t size =
      receive_datagram(socket.native_handle(), into, way.client.data(), length, way.local);
  if (size >= 0) way.client.resize(length);
  return size;
}

/// Calls send_datagram() with the types of the relay.
bool send(udp::socket& socket, Bytes datagram, const DatagramAddresses& way) {
  return send_datagram(socket.native_handle(), datagram, way.client.data(),
                       static_cast<socklen_t>(way.client.size()), way.local);
}

}  // namespace

struct LinkRelay::Parts {
  /// A UDP socket of the relay, and the server's endpoint to which it forwards the datagrams.
  struct ScenePort {
    udp::socket socket;
    udp::endpoint scene;
    struct Client {
      std::shared_ptr<RelayClient> relayed;
      std::shared_ptr<DatagramAddresses> back;
    };
    std::map<udp::endpoint, Client> clients;
    std::array<std::uint8_t, kMaxDatagram + 1> buffer{};
  };
  struct Known {
    udp::endpoint address;
    std::uint16_t scene_port = 0;
    std::shared_ptr<RelayClient> client;  // null: the client was removed
    Json account;                         // final counters of a removed client
  };

  LinkRelayOptions options;
  asio::io_context io{1};
  tcp::endpoint server;
  tcp::acceptor acceptor{io};
  asio::ip::address address;
  std::vector<std::unique_ptr<ScenePort>> ports;
  std::vector<Known> known;  // all clients since the start
  std::size_t alive = 0;
  std::uint64_t refused = 0;  // number of datagrams from clients for which there was no room

  explicit Parts(const LinkRelayOptions& asked) : options(asked), server(find(io, asked.server)) {
    Error error;
    address = asio::ip::make_address(asked.address, error);
    if (error)
      throw std::runtime_error("'" + asked.address + "' is no IP address; give one in --address");
    if (asked.scenes < 1 || asked.scenes > control::kMaxScenes)
      throw std::runtime_error(std::to_string(asked.scenes) + " scenes are not within 1 to " +
                               std::to_string(control::kMaxScenes) + "; see --scenes");
    open_ports();
    accept();
  }

  /// Opens a UDP port for each scene port of the server, in the same order. A client computes the
  /// port of its scene from the control port and the number of the scene.
  void open_ports() {
    auto sockets = listen_with_room(options.port, [this](std::uint16_t port) {
      listen(port);
      return open_scene_ports(io, address, acceptor.local_endpoint().port() + 1u, options.scenes,
                              "--listen");
    });
    constexpr std::size_t kLastPort = 65535;
    for (std::size_t i = 0; i < sockets.size() && server.port() + 1 + i <= kLastPort; ++i) {
      const auto scene = static_cast<std::uint16_t>(server.port() + 1 + i);
      ports.push_back(std::make_unique<ScenePort>(
          ScenePort{std::move(sockets[i]), {server.address(), scene}, {}, {}}));
      ports.back()->socket.non_blocking(true);
      if (address.is_unspecified() && !report_local_address(ports.back()->socket.native_handle()))
        throw listen_error("udp", address, ports.back()->socket.local_endpoint().port(),
                           {errno, std::generic_category()}, "--listen");
      await_clients(*ports.back());
    }
  }

  void listen(std::uint16_t port) {
    const tcp::endpoint own(address, port);
    acceptor = tcp::acceptor(io);
    try {
      acceptor.open(own.protocol());
      acceptor.set_option(tcp::acceptor::reuse_address(true));
      serve_both_families(acceptor, address);
      acceptor.bind(own);
      acceptor.listen();
    } catch (const std::system_error& failed) {
      throw listen_error("tcp", address, port, failed.code(), "--listen");
    }
  }

  void accept() {
    acceptor.async_accept([this](const Error& error, tcp::socket client) {
      if (error == asio::error::operation_aborted) return;
      if (!error) std::make_shared<ControlBridge>(std::move(client))->start(server);
      accept();
    });
  }

  void await_clients(ScenePort& port) {
    port.socket.async_wait(udp::socket::wait_read, [this, &port](const Error& stopped) {
      if (stopped) return;
      const Nanoseconds now = relay_now();
      for (int i = 0; i < kBurst; ++i) {
        DatagramAddresses from;
        const ssize_t size = receive(port.socket, port.buffer, from);
        if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
        if (size < 0) continue;
        if (RelayClient* client = client_at(port, from, now))
          client->enter({port.buffer.data(), static_cast<std::size_t>(size)}, now);
        else
          ++refused;
      }
      await_clients(port);
    });
  }

  RelayClient* client_at(ScenePort& port, const DatagramAddresses& from, Nanoseconds now) {
    const auto found = port.clients.find(from.client);
    if (found != port.clients.end()) {
      *found->second.back = from;  // the client may now send to another local address
      return found->second.relayed.get();
    }
    if (alive >= kMaxClients) forget_silent(now);
    if (alive >= kMaxClients) return nullptr;
    try {
      const auto back = std::make_shared<DatagramAddresses>(from);
      auto client = std::make_shared<RelayClient>(
          io.get_executor(), port.scene,
          std::make_unique<TwoWayLink>(options.link, known.size(), kLinkRoom),
          [&port, back](Bytes datagram) { return send(port.socket, datagram, *back); });
      client->start();
      known.push_back({from.client, port.scene.port(), client, {}});
      ++alive;
      return port.clients.emplace(from.client, ScenePort::Client{std::move(client), back})
          .first->second.relayed.get();
    } catch (const std::exception&) {  // no more sockets, or no memory
      return nullptr;
    }
  }

  void forget_silent(Nanoseconds now) {
    for (Known& one : known) {
      if (!one.client || now - one.client->last_heard() <= kForgotten) continue;
      one.account = account(one);
      one.client->close();
      one.client.reset();
      --alive;
      for (auto& port : ports)
        if (port->scene.port() == one.scene_port) port->clients.erase(one.address);
    }
  }

  static Json account(const Known& one) {
    return {{"client", to_string(Endpoint{one.address.address().to_string(), one.address.port()})},
            {"scene_port", one.scene_port},
            {"unsent", one.client->unsent()},
            {"link", link_json(one.client->link())}};
  }

  std::string report() const {
    Json clients = Json::array();
    for (const Known& one : known) clients.push_back(one.client ? account(one) : one.account);
    const Json report = {{"to", to_string(options.server)},
                         {"link", options.link.text},
                         {"refused", refused},
                         {"clients", clients}};
    return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  }
};

LinkRelay::LinkRelay(const LinkRelayOptions& options) : parts_(std::make_unique<Parts>(options)) {}
LinkRelay::~LinkRelay() = default;

std::uint16_t LinkRelay::control_port() const { return parts_->acceptor.local_endpoint().port(); }
void LinkRelay::run() { parts_->io.run(); }
void LinkRelay::stop() { parts_->io.stop(); }
std::string LinkRelay::report() const { return parts_->report(); }

}  // namespace feltwire
