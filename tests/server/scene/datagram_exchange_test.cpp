// The UDP port of a scene without a thread: batches, the answers to them, and when an exchange
// stops.

#include "server/scene/datagram_exchange.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <asio/io_context.hpp>
#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <stdexcept>

#include "protocol/net/clock.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::datagram_exchange_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kId = 0x100;

/// A port with one session, and its client.
struct Port {
  Port() {
    sessions.answer(test::join_request(), kId, test::keys(kId), clock());
    for (std::uint64_t n = 1; n <= 2; ++n) send_sample();
  }
  /// Sends a sample and waits until the kernel has it for the server.
  void send_sample() {
    ++sent;
    client.send(encoder.samples(kId, sent, test::hand_batch(sent)));
    pollfd input{datagrams.socket().native_handle(), POLLIN, 0};
    ASSERT_EQ(::poll(&input, 1, test::kPatience), 1);
  }
  std::size_t exchange() {
    std::optional<Nanoseconds> until;
    return datagrams.exchange(until);
  }

  asio::io_context io{1};
  Scene scene = test::room();
  SceneSessions sessions{scene, 100s, 4};
  std::function<Nanoseconds()> clock = monotonic_now;
  std::atomic<int> posts{0};
  DatagramExchange datagrams{
      io, {.address = asio::ip::make_address("127.0.0.1")}, sessions, clock, posts};
  test::RawSocket client{SOCK_DGRAM, datagrams.port()};
  test::SealedEncoder encoder{test::Way::up};
  std::uint64_t sent = 0;
};

TEST(DatagramExchange, AnswersAllThatHasCome) {
  Port port;
  EXPECT_FALSE(port.datagrams.has_datagrams());
  EXPECT_EQ(port.exchange(), 2u);
  EXPECT_FALSE(port.client.receive().empty());
  EXPECT_FALSE(port.client.receive().empty());
  EXPECT_EQ(port.sessions.counters().samples.replies, 2u);
  EXPECT_EQ(port.exchange(), 0u);
  EXPECT_EQ(port.datagrams.unsent(), 0u);
}

TEST(DatagramExchange, StopsAfterOneAnswerIfARequestIsPosted) {
  Port port;
  port.posts = 1;
  EXPECT_EQ(port.exchange(), 1u);
  EXPECT_TRUE(port.datagrams.has_datagrams());
  port.posts = 0;
  EXPECT_EQ(port.exchange(), 1u);
  EXPECT_FALSE(port.datagrams.has_datagrams());
}

TEST(DatagramExchange, GoesOnOnlyAfterAFullBatchInItsTime) {
  Port port;
  std::optional<Nanoseconds> until;
  const std::size_t taken = port.datagrams.exchange(until);
  ASSERT_TRUE(until);
  EXPECT_GT(*until, port.datagrams.served_at() - 1s);
  EXPECT_FALSE(port.datagrams.may_go_on(taken, until));
  constexpr std::size_t kFull = 64;
  EXPECT_TRUE(port.datagrams.may_go_on(kFull, port.datagrams.served_at() + 1ms));
  EXPECT_FALSE(port.datagrams.may_go_on(kFull, port.datagrams.served_at()));
  port.posts = 1;
  EXPECT_FALSE(port.datagrams.may_go_on(kFull, port.datagrams.served_at() + 1ms));
}

TEST(DatagramExchange, AllocatesNothing) {
  Port port;
  port.exchange();
  port.send_sample();
  const std::size_t before = test::allocations();
  EXPECT_EQ(port.exchange(), 1u);
  EXPECT_EQ(test::allocations(), before);
}

TEST(DatagramExchange, SaysGoodbyeToKnownAddressesOnly) {
  Port port;
  port.datagrams.say(port.sessions.evict(kId));  // no sample of it was taken yet
  EXPECT_EQ(port.exchange(), 2u);                // samples of no session
  pollfd nothing{port.client.descriptor(), POLLIN, 0};
  EXPECT_EQ(::poll(&nothing, 1, 0), 0);

  Port known;
  known.exchange();
  known.client.receive();
  known.client.receive();
  known.datagrams.say(known.sessions.evict(kId));
  EXPECT_FALSE(known.client.receive().empty());
}

TEST(DatagramExchange, AUsedPortIsRefusedInOneLine) {
  const Port port;
  asio::io_context io{1};
  const Scene scene = test::room();
  SceneSessions sessions(scene, 100s, 4);
  const std::function<Nanoseconds()> clock = monotonic_now;
  const std::atomic<int> posts{0};
  EXPECT_THROW(
      DatagramExchange(
          io, {.address = asio::ip::make_address("127.0.0.1"), .port = port.datagrams.port()},
          sessions, clock, posts),
      std::runtime_error);
}

}  // namespace
}  // namespace feltwire::datagram_exchange_test
