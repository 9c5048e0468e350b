// Tests the control endpoint alone, with clients that are silent or do not read.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "tests/server/endpoint.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::control_endpoint_test {
namespace {

using namespace std::chrono_literals;
using test::ControlClient;
using test::Endpoint;
using test::RawSocket;
using test::served;

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

/// A client sends requests without reading answers. The endpoint must keep only one answer and then
/// close the connection. The endpoint must serve others meanwhile.
TEST(ControlEndpoint, WhoDoesNotReadIsClosed) {
  control::SceneList long_answer;
  const std::string name(control::kMaxName, 'x');
  for (std::size_t n = 0; n < 200; ++n) long_answer.scenes.push_back({name, 1, 2, 3});
  Endpoint endpoint({.address = {}, .idle_timeout = 200ms, .handshake_burst = 1e6}, long_answer);
  ControlClient deaf(endpoint.port());
  const int small = 1;
  ::setsockopt(deaf.descriptor(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  const auto request = control::encode(control::ListScenes{});
  ::fcntl(deaf.descriptor(), F_SETFL, O_NONBLOCK);
  std::signal(SIGPIPE, SIG_IGN);  // OpenSSL raises SIGPIPE when it writes to a closed socket.
  // The endpoint first stops reading, and then closes the connection.
  const auto is_closed = [&] {
    const int sent =
        SSL_write(deaf.tls().native(), request.data(), static_cast<int>(request.size()));
    return sent <= 0 && SSL_get_error(deaf.tls().native(), sent) != SSL_ERROR_WANT_WRITE;
  };
  test::eventually("the end of the connection", [&] {
    ControlClient other(endpoint.port());
    EXPECT_EQ(other.ask<control::SceneList>(control::ListScenes{}).scenes.size(), 200u);
    return is_closed();
  });
}

/// Until a valid token arrives, a single time limit must apply, even for an active stranger.
TEST(ControlEndpoint, WhoIsSlowToBeKnownIsClosed) {
  Endpoint endpoint({.address = {}, .handshake_timeout = 100ms, .idle_timeout = kNever},
                    control::SceneList{});
  RawSocket mute(SOCK_STREAM, endpoint.port());
  EXPECT_TRUE(mute.receive().empty());

  RawSocket half(SOCK_STREAM, endpoint.port());  // only the beginning of a TLS record
  const std::vector<std::uint8_t> beginning = {0x16, 0x03, 0x01, 0x02, 0x00, 0x01};
  half.send(beginning);
  EXPECT_TRUE(half.receive().empty());

  ControlClient tokenless(endpoint.port(), AF_INET, Secret());
  EXPECT_TRUE(tokenless.closed());

  ControlClient slow(endpoint.port(), AF_INET, Secret());
  const auto frame = control::encode(control::Authenticate{Secret("fw_x")});
  slow.send_raw({frame.data(), frame.size() - 1});
  EXPECT_TRUE(slow.closed());
  EXPECT_EQ(endpoint.counters().too_slow, 4u);
}

TEST(ControlEndpoint, StrangersFramesAreShort) {
  Endpoint endpoint(kNever, 8, control::SceneList{});
  ControlClient stranger(endpoint.port(), AF_INET, Secret());
  const std::vector<std::uint8_t> frame = {0x01, 0x02, 0x00, 0x00};  // announces 513 bytes
  stranger.send_raw(frame);
  const auto answer = stranger.receive();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(std::get<control::Refused>(*answer).code, control::RefusalCode::malformed);
  EXPECT_TRUE(stranger.closed());
}

TEST(ControlEndpoint, ARefusedStrangerIsClosed) {
  Endpoint endpoint(kNever, 8, control::SceneList{});
  ControlClient stranger(endpoint.port(), AF_INET, Secret());
  EXPECT_EQ(stranger.ask<control::Refused>(control::ListScenes{}).code,
            control::RefusalCode::unauthenticated);
  EXPECT_TRUE(stranger.closed());
}

/// After a refusal the endpoint discards input, so that the stranger gets the reason. The endpoint
/// must not discard input forever.
TEST(ControlEndpoint, ARefusedStrangerThatSendsWithoutEndIsClosed) {
  Endpoint endpoint({.address = {}, .handshake_timeout = kNever, .idle_timeout = kNever},
                    control::SceneList{});
  ControlClient stranger(endpoint.port(), AF_INET, Secret());
  stranger.ask<control::Refused>(control::ListScenes{});
  const std::vector<std::uint8_t> more(65536);
  constexpr std::size_t kEndless = std::size_t{256} << 20U;
  std::size_t sent = 0;
  while (sent < kEndless) {
    const ssize_t count = ::send(stranger.descriptor(), more.data(), more.size(), MSG_NOSIGNAL);
    if (count <= 0) break;
    sent += static_cast<std::size_t>(count);
  }
  EXPECT_LT(sent, kEndless);
}

TEST(ControlEndpoint, OlderTlsIsRefused) {
  Endpoint endpoint(kNever, 8, control::SceneList{});
  for (const int version : {TLS1_2_VERSION, TLS1_1_VERSION}) {
    const test::TlsContext context = test::client_context(version);
    const RawSocket socket(SOCK_STREAM, endpoint.port());
    test::TlsConnection tls(context.get(), socket.descriptor());
    EXPECT_FALSE(tls.connect()) << version;
  }
  EXPECT_TRUE(served(endpoint.port()));
  EXPECT_GE(endpoint.counters().failed, 1u);
}

TEST(ControlEndpoint, NoPlainTextIsRead) {
  Endpoint endpoint(kNever, 8, control::SceneList{});
  RawSocket plain(SOCK_STREAM, endpoint.port());
  plain.send(control::encode(control::ListScenes{}));
  const auto answer = plain.receive();  // a TLS alert, or nothing
  EXPECT_TRUE(answer.empty() || answer.front() == 0x15);
  test::eventually("the end of the connection", [&] { return plain.receive().empty(); });
  EXPECT_EQ(endpoint.counters().failed, 1u);
}

}  // namespace
}  // namespace feltwire::control_endpoint_test
