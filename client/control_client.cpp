#include "client/control_client.hpp"

#include <algorithm>
#include <array>
#include <asio/buffer.hpp>
#include <asio/connect.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>
#include <variant>

#include "protocol/placeholder_keys.hpp"

namespace feltwire {
namespace {

using asio::ip::tcp;

/// One question and its answer. A connection of its own: joining is rare, and nothing of it
/// outlives the answer.
class Conversation {
 public:
  Conversation(const Endpoint& server, std::chrono::milliseconds timeout)
      : server_(to_string(server)), timeout_(timeout), socket_(context_) {
    asio::error_code error;
    tcp::resolver resolver(context_);
    const auto found = resolver.resolve(server.host, std::to_string(server.port), error);
    if (error)
      throw SessionError("cannot find host '" + server.host + "': " + error.message() +
                         "; check the name in --connect");
    await(
        [&](auto done) {
          asio::async_connect(socket_, found,
                              [done](asio::error_code e, const tcp::endpoint&) { done(e); });
        },
        "cannot connect to ",
        "; is feltwire-server running there, and is the port its control port?");
  }

  control::Message ask(const control::Message& question) {
    const std::vector<std::uint8_t> frame = control::encode(question);
    const std::string what = "no answer from ";
    const std::string remedy = "; is the port the control port of a feltwire-server?";
    await(
        [&](auto done) {
          asio::async_write(socket_, asio::buffer(frame),
                            [done](asio::error_code e, std::size_t) { done(e); });
        },
        what, remedy);

    std::array<std::uint8_t, 4> prefix{};
    read(prefix.data(), prefix.size(), what, remedy);
    std::size_t size = 0;
    for (std::size_t i = 0; i < prefix.size(); ++i) size |= std::size_t{prefix[i]} << (8 * i);
    if (size == 0 || size > control::kMaxFrame) bad_answer();
    std::vector<std::uint8_t> body(size);
    read(body.data(), body.size(), what, remedy);
    std::optional<control::Message> answer = control::decode(body);
    if (!answer) bad_answer();
    if (const auto* refused = std::get_if<control::Refused>(&*answer))
      throw SessionError(server_ + " refused: " + refused->reason);
    return *std::move(answer);
  }

  [[noreturn]] void bad_answer() const {
    throw SessionError(
        server_ +
        " answered with something that is no feltwire message; is the port the control "
        "port of a feltwire-server of this version?");
  }

  asio::ip::address peer() const { return socket_.remote_endpoint().address(); }

 private:
  void read(std::uint8_t* to, std::size_t size, const std::string& what,
            const std::string& remedy) {
    await(
        [&](auto done) {
          asio::async_read(socket_, asio::buffer(to, size),
                           [done](asio::error_code e, std::size_t) { done(e); });
        },
        what, remedy);
  }

  /// Starts an operation and runs it to its end or the timeout.
  template <class Start>
  void await(Start start, const std::string& what, const std::string& remedy) {
    asio::error_code result = asio::error::would_block;
    start([&result](asio::error_code error) { result = error; });
    context_.restart();
    context_.run_for(timeout_);
    if (result == asio::error::would_block) {
      asio::error_code ignored;
      socket_.close(ignored);  // ends the operation, so that it lets go of `result`
      context_.restart();
      context_.run();
      throw SessionError(what + server_ + " within " + std::to_string(timeout_.count()) + " ms" +
                         remedy);
    }
    if (result) throw SessionError(what + server_ + ": " + result.message() + remedy);
  }

  std::string server_;
  std::chrono::milliseconds timeout_;
  asio::io_context context_;
  tcp::socket socket_;
};

Address address_of(const asio::ip::udp::endpoint& endpoint) {
  Address address;
  address.size = static_cast<socklen_t>(endpoint.size());
  std::memcpy(&address.storage, endpoint.data(), endpoint.size());
  return address;
}

}  // namespace

Endpoint parse_endpoint(std::string_view text) {
  const auto fail = [&](const char* what) {
    throw std::invalid_argument("'" + std::string(text) + "' " + what +
                                "; write HOST:PORT, e.g. localhost:7400 or [::1]:7400");
  };
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) fail("has no port");
  std::string_view host = text.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    fail("is an IPv6 address without brackets");
  }
  if (host.empty()) fail("has no host");
  const std::string_view digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [rest, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || rest != digits.data() + digits.size() || port == 0)
    fail("has no port from 1 to 65535");
  return {std::string(host), port};
}

std::string to_string(const Endpoint& endpoint) {
  const bool v6 = endpoint.host.find(':') != std::string::npos;
  return (v6 ? "[" + endpoint.host + "]" : endpoint.host) + ":" + std::to_string(endpoint.port);
}

Joined join(const Endpoint& server, const control::JoinRequest& request,
            std::chrono::milliseconds timeout) {
  Conversation conversation(server, timeout);
  const control::Message answer = conversation.ask(request);
  const auto* accepted = std::get_if<control::JoinAccepted>(&answer);
  if (accepted == nullptr || accepted->udp_port == 0 || !std::isfinite(accepted->silence_timeout) ||
      !std::isfinite(accepted->stiffness) || accepted->stiffness < 0.0)
    conversation.bad_answer();
  try {
    validate(accepted->parameters);
  } catch (const std::invalid_argument& error) {
    throw SessionError(to_string(server) + " granted parameters that cannot be: " + error.what());
  }
  return {*accepted, address_of({conversation.peer(), accepted->udp_port}),
          placeholder_keys(accepted->session)};
}

std::vector<control::SceneEntry> list_scenes(const Endpoint& server,
                                             std::chrono::milliseconds timeout) {
  Conversation conversation(server, timeout);
  control::Message answer = conversation.ask(control::ListScenes{});
  auto* list = std::get_if<control::SceneList>(&answer);
  if (list == nullptr) conversation.bad_answer();
  return std::move(list->scenes);
}

}  // namespace feltwire
