#pragma once
// The control endpoint without a service behind it.

#include <asio/post.hpp>
#include <thread>

#include "server/control/control_endpoint.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire::test {

/// An endpoint in its own thread. It accepts any token and answers every request except a join.
class Endpoint {
 public:
  Endpoint(ControlOptions options, const control::Message& answer,
           const std::string& authorities = {})
      : endpoint_(io_, local(options), identity(), authorities,
                  [answer](ControlPeer& peer, const control::Message& request, const auto& done) {
                    if (std::holds_alternative<control::Authenticate>(request)) {
                      peer.token = "some";
                      done(control::Authenticated{});
                    } else if (peer.token.empty()) {
                      done(control::Refused{control::RefusalCode::unauthenticated, "no"});
                    } else if (!std::holds_alternative<control::JoinRequest>(request)) {
                      done(answer);
                    }
                  }) {
    endpoint_.start();
    thread_ = std::thread([this] { io_.run(); });
  }
  Endpoint(std::chrono::milliseconds idle, std::size_t connections, const control::Message& answer)
      : Endpoint({.address = {}, .idle_timeout = idle, .max_connections = connections}, answer) {}
  ~Endpoint() { stop(); }
  /// Stops the endpoint and returns its counters.
  ControlCounters counters() {
    stop();
    return endpoint_.counters();
  }
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;
  std::uint16_t port() const { return endpoint_.port(); }

 private:
  static ControlOptions local(ControlOptions options) {
    options.address = asio::ip::make_address("127.0.0.1");
    return options;
  }
  void stop() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] {
      endpoint_.close();
      io_.stop();
    });
    thread_.join();
  }

  asio::io_context io_{1};
  ControlEndpoint endpoint_;
  std::thread thread_;
};

/// True if a connection got through TLS and was admitted.
inline bool served(std::uint16_t port, const char* from = nullptr) {
  try {
    ControlClient client(port, AF_INET, admin_token().text, from);
    client.ask<control::SceneList>(control::ListScenes{});
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace feltwire::test
