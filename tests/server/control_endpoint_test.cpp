// The control endpoint alone: who is silent, and who does not read.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <asio/post.hpp>
#include <memory>
#include <thread>

#include "server/control.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire {
namespace {

using namespace std::chrono_literals;
using test::ControlClient;

/// An endpoint in a thread of its own. It answers every request but one: a join is never answered.
class Endpoint {
 public:
  Endpoint(std::chrono::milliseconds idle, std::size_t connections, const control::Message& answer)
      : endpoint_(io_,
                  {.address = asio::ip::make_address("127.0.0.1"),
                   .idle_timeout = idle,
                   .max_connections = connections},
                  [answer](const control::Message& request, const auto& done) {
                    if (!std::holds_alternative<control::JoinRequest>(request)) done(answer);
                  }) {
    endpoint_.start();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Endpoint() {
    asio::post(io_, [this] {
      endpoint_.close();
      io_.stop();
    });
    thread_.join();
  }
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;
  std::uint16_t port() const { return endpoint_.port(); }

 private:
  asio::io_context io_{1};
  ControlEndpoint endpoint_;
  std::thread thread_;
};

constexpr auto kShort = 30ms;
constexpr auto kNever = 1h;

TEST(ControlEndpoint, WhoSendsNoRequestIsClosed) {
  Endpoint endpoint(kShort, 8, control::SceneList{});
  ControlClient silent(endpoint.port());
  EXPECT_TRUE(silent.closed());

  ControlClient once(endpoint.port());
  once.ask<control::SceneList>(control::ListScenes{});
  EXPECT_TRUE(once.closed());

  // Half a frame is no request.
  ControlClient slow(endpoint.port());
  const auto frame = control::encode(control::ListScenes{});
  slow.send_raw({frame.data(), frame.size() - 1});
  EXPECT_TRUE(slow.closed());
}

TEST(ControlEndpoint, WhoseAnswerNeverComesIsClosed) {
  Endpoint endpoint(kShort, 8, control::SceneList{});
  ControlClient joining(endpoint.port());
  joining.send(control::JoinRequest{});
  EXPECT_TRUE(joining.closed());
}

/// Requests and requests, and no answer is ever read: the endpoint waits with one answer, not with
/// a pile of them, then closes; others are served meanwhile.
TEST(ControlEndpoint, WhoDoesNotReadIsClosed) {
  control::SceneList long_answer;
  const std::string name(control::kMaxName, 'x');
  for (std::size_t n = 0; n < 200; ++n) long_answer.scenes.push_back({name, 1, 2, 3});
  Endpoint endpoint(200ms, 8, long_answer);
  ControlClient deaf(endpoint.port());
  const int small = 1;
  ::setsockopt(deaf.descriptor(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  const auto request = control::encode(control::ListScenes{});
  // Until the endpoint reads no more, and then until it has hung up.
  const auto is_closed = [&] {
    return ::send(deaf.descriptor(), request.data(), request.size(), MSG_NOSIGNAL | MSG_DONTWAIT) <
               0 &&
           errno != EAGAIN && errno != EWOULDBLOCK;
  };
  while (!is_closed()) {
    ControlClient other(endpoint.port());
    ASSERT_EQ(other.ask<control::SceneList>(control::ListScenes{}).scenes.size(), 200u);
  }
}

TEST(ControlEndpoint, TooManyConnectionsAreRefused) {
  Endpoint endpoint(kNever, 2, control::SceneList{});
  ControlClient first(endpoint.port());
  first.ask<control::SceneList>(control::ListScenes{});
  {
    ControlClient second(endpoint.port());
    second.ask<control::SceneList>(control::ListScenes{});
    ControlClient third(endpoint.port());
    const auto refusal = third.receive();
    ASSERT_TRUE(refusal.has_value());
    EXPECT_EQ(std::get<control::Refused>(*refusal).code, control::RefusalCode::full);
    EXPECT_TRUE(third.closed());
    first.ask<control::SceneList>(control::ListScenes{});
  }
  // Both have hung up: there is room again, as soon as the endpoint has seen it.
  for (bool served = false; !served;) {
    ControlClient next(endpoint.port());
    next.send(control::ListScenes{});
    const auto answer = next.receive();
    served = answer && std::holds_alternative<control::SceneList>(*answer);
  }
}

/// Refusals wait to be read too, and are connections: there is an end to them.
TEST(ControlEndpoint, AFloodOfConnectionsIsCutOff) {
  Endpoint endpoint(kNever, 2, control::SceneList{});
  std::vector<std::unique_ptr<ControlClient>> clients;
  for (int n = 0; n < 2; ++n) {
    clients.push_back(std::make_unique<ControlClient>(endpoint.port()));
    clients.back()->ask<control::SceneList>(control::ListScenes{});
  }
  for (int n = 0; n < 2; ++n) {
    clients.push_back(std::make_unique<ControlClient>(endpoint.port()));
    EXPECT_TRUE(clients.back()->receive().has_value());
  }
  for (int n = 0; n < 20; ++n) {
    clients.push_back(std::make_unique<ControlClient>(endpoint.port()));
    EXPECT_TRUE(clients.back()->closed());
  }
  clients.front()->ask<control::SceneList>(control::ListScenes{});
}

}  // namespace
}  // namespace feltwire
