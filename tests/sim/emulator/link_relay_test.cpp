// Tests the relay between real sockets of this machine, with clients and a server in one process.

#include "sim/emulator/link_relay.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "server/scene/scene_ports.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/peer.hpp"

namespace feltwire::link_relay_test {
namespace {

using nlohmann::json;
using testing::Client;
using testing::kPatience;
using testing::kStroke;
using testing::Loopback;

/// Runs a relay in its own thread.
class Relay {
 public:
  Relay(const Endpoint& server, const char* link, std::uint16_t port = 0,
        const std::string& address = "127.0.0.1")
      : relay_({.address = address, .port = port, .server = server, .link = parse_link(link)}),
        thread_([this] { relay_.run(); }) {}
  ~Relay() { stop(); }
  ServerAccess access() const { return test::access(relay_.control_port()); }
  std::uint16_t port() const { return relay_.control_port(); }
  /// Stops the relay and returns its report.
  json report() {
    stop();
    return json::parse(relay_.report());
  }

 private:
  void stop() {
    relay_.stop();
    if (thread_.joinable()) thread_.join();
  }
  LinkRelay relay_;
  std::thread thread_;
};

class LinkRelayTest : public Loopback {};

TEST_F(LinkRelayTest, ScenesAreListedAsBehindTheServer) {
  Relay relay(endpoint.endpoint, "delay=0");
  const auto direct = list_scenes(endpoint, kPatience);
  const auto relayed = list_scenes(relay.access(), kPatience);
  ASSERT_EQ(relayed.size(), 1u);
  EXPECT_EQ(relayed[0].name, "floor");
  EXPECT_EQ(relayed[0].objects, direct[0].objects);
  EXPECT_EQ(relayed[0].port_offset, direct[0].port_offset);
}

TEST_F(LinkRelayTest, RefusalsComeThrough) {
  Relay relay(endpoint.endpoint, "delay=0");
  try {
    Client lost(relay.access(), kStroke, {}, "cellar");
    FAIL() << "joined a scene that is not there";
  } catch (const SessionError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("cellar"));
  }
}

/// A relay listens on every address. The answers must leave from the address to which the client
/// sent.
TEST_F(LinkRelayTest, AnswersFromTheAddressThatTheClientSpokeTo) {
  Relay relay(endpoint.endpoint, "delay=0", 0, "0.0.0.0");
  ServerAccess access = relay.access();
  access.endpoint.host = "127.0.0.2";
  Client client(access, kStroke, {}, "floor");
  client.start();
  client.finish();
  EXPECT_GT(client.transport.statistics().received, 0u);
}

TEST_F(LinkRelayTest, TwoClientsApartEachWithItsOwnFates) {
  Relay relay(endpoint.endpoint, "delay=2,loss=10,seed=3");
  Client first(relay.access(), kStroke, {}, "floor");
  Client second(relay.access(), kStroke, {}, "floor");
  EXPECT_NE(first.joined.accepted.session, second.joined.accepted.session);
  for (Client* client : {&first, &second}) client->start();
  for (Client* client : {&first, &second}) client->finish();

  const json report = relay.report();
  ASSERT_EQ(report["clients"].size(), 2u);
  EXPECT_EQ(report["refused"], 0);
  std::vector<std::uint64_t> entered;
  for (const json& one : report["clients"]) {
    const json& up = one["link"]["up"];
    const json& down = one["link"]["down"];
    entered.push_back(up["entered"]);
    EXPECT_EQ(one["unsent"], 0);
    EXPECT_GT(up["lost"], 0);
    EXPECT_GT(down["lost"], 0);
    EXPECT_EQ(down["entered"].get<std::uint64_t>() + down["duplicated"].get<std::uint64_t>(),
              down["delivered"].get<std::uint64_t>() + down["lost"].get<std::uint64_t>() +
                  down["in_flight"].get<std::uint64_t>());
    EXPECT_GE(up["measured_delay_ms"]["min"], 2.0);
    EXPECT_GE(down["measured_delay_ms"]["min"], 2.0);
  }
  for (Client* client : {&first, &second}) {
    const ServoStatistics& s = client->servo.statistics();
    EXPECT_EQ(client->result->end, EndReason::device_ended);
    EXPECT_GT(s.replies.answered, s.samples / 2);
    EXPECT_LT(s.replies.answered, s.samples);
    EXPECT_EQ(client->servo.port().violations(), 0u);
    EXPECT_EQ(client->transport.statistics().dropped, TransportStatistics{}.dropped);
    EXPECT_THAT(entered, ::testing::Contains(::testing::AllOf(::testing::Ge(s.samples),
                                                              ::testing::Le(s.samples + 3))));
  }
}

TEST_F(LinkRelayTest, TheFirstClientMeetsWhatALinkOfItsOwnWouldDo) {
  constexpr const char* kLink = "delay=2,loss=10,down.burst=3,seed=7";
  Relay relay(endpoint.endpoint, kLink);
  Client client(relay.access(), kStroke, {}, "floor");
  client.start();
  client.finish();
  const ServoStatistics& s = client.servo.statistics();

  const TwoWayLinkOptions options = parse_link(kLink);
  LinkModel up(options.up, link_key(options.seed, 0, LinkDirection::up));
  LinkModel down(options.down, link_key(options.seed, 0, LinkDirection::down));
  std::uint64_t through = 0, answered = 0;
  for (std::uint64_t i = 0; i < s.samples; ++i)
    through += static_cast<std::uint64_t>(up.next(200, Nanoseconds(0)).copies);
  for (std::uint64_t i = 0; i < through; ++i)
    answered += static_cast<std::uint64_t>(down.next(200, Nanoseconds(0)).copies);
  EXPECT_EQ(s.replies.answered, answered);
  EXPECT_LT(answered, s.samples);
}

std::uint16_t port_of(const Address& address) {
  sockaddr_in four;
  std::memcpy(&four, &address.storage, sizeof four);
  return ntohs(four.sin_port);
}

/// The relay has no keys of either end. Certificate, token, answers and the session's keys must
/// come from the two ends.
TEST_F(LinkRelayTest, NothingButTheWayIsTheRelays) {
  Relay relay(endpoint.endpoint, "lan");
  const Joined joined =
      join(relay.access(), {"tester", "floor", builtin_device("simulated"), {}}, kPatience);
  EXPECT_EQ(port_of(joined.datagrams), relay.port() + 1);
  ServerAccess stranger = relay.access();
  std::get<Fingerprint>(stranger.credentials.trust)[0] ^= 1;
  EXPECT_THROW(list_scenes(stranger, kPatience), SessionError);
}

TEST(LinkRelay, APortThatIsTakenBehindTheControlPortIsSaid) {
  const testing::LocalSocket taken(SOCK_DGRAM);
  EXPECT_THAT(
      [&] {
        LinkRelay(
            {.port = static_cast<std::uint16_t>(taken.port() - 1), .server = {"127.0.0.1", 6720}});
      },
      ::testing::ThrowsMessage<std::runtime_error>(::testing::HasSubstr("--listen")));
  EXPECT_THAT(
      [] {
        LinkRelay({.server = {"127.0.0.1", 6720}, .scenes = 0});
      },
      ::testing::ThrowsMessage<std::runtime_error>(::testing::HasSubstr("--scenes")));
}

/// The test opens the sockets of a server with three scenes: an unused control port, and the ports
/// after this port.
TEST(LinkRelay, DatagramsPassBothWaysUnchanged) {
  asio::io_context io;
  std::uint16_t base = 0;
  auto scenes = listen_with_room(0, [&](std::uint16_t) {
    const testing::LocalSocket control(SOCK_STREAM);
    base = control.port();
    return open_scene_ports(io, asio::ip::make_address("127.0.0.1"), base + 1u, 3);
  });
  const LinkRelayOptions options{.server = {"127.0.0.1", base}, .link = parse_link("delay=1")};
  LinkRelay relay(options);
  std::thread thread([&] { relay.run(); });

  testing::LocalSocket client(SOCK_DGRAM);
  std::vector<std::uint8_t> buffer(4096);
  for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
    testing::LocalSocket::limit(scenes[scene].native_handle());
    sockaddr_in port{};
    port.sin_family = AF_INET;
    port.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    port.sin_port = htons(static_cast<std::uint16_t>(relay.control_port() + 1 + scene));
    for (const std::size_t size :
         {std::size_t{1}, std::size_t{0}, kMaxDatagram, kMaxDatagram + 9}) {
      std::vector<std::uint8_t> datagram(size);
      for (std::size_t i = 0; i < size; ++i) datagram[i] = static_cast<std::uint8_t>(7 * i + 1);
      std::vector<std::uint8_t> expected = datagram;
      expected.resize(std::min(size, kMaxDatagram + 1));  // still too long for the receiver

      ASSERT_GE(::sendto(client.descriptor(), datagram.data(), size, 0,
                         reinterpret_cast<const sockaddr*>(&port), sizeof port),
                0);
      Address from;
      from.size = sizeof from.storage;
      const ssize_t up = ::recvfrom(scenes[scene].native_handle(), buffer.data(), buffer.size(), 0,
                                    reinterpret_cast<sockaddr*>(&from.storage), &from.size);
      ASSERT_EQ(up, static_cast<ssize_t>(expected.size()));
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), buffer.begin()));

      ASSERT_GE(::sendto(scenes[scene].native_handle(), datagram.data(), size, 0,
                         reinterpret_cast<const sockaddr*>(&from.storage), from.size),
                0);
      const ssize_t down = ::recv(client.descriptor(), buffer.data(), buffer.size(), 0);
      ASSERT_EQ(down, static_cast<ssize_t>(expected.size()));
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), buffer.begin()));
    }
  }
  relay.stop();
  thread.join();
}

TEST(LinkRelay, FaultsAreOneLine) {
  EXPECT_THAT(
      [] {
        LinkRelay({.server = {"no-such-host.invalid", 6720}});
      },
      ::testing::ThrowsMessage<std::runtime_error>(::testing::HasSubstr("--to")));
  const testing::LocalSocket taken(SOCK_STREAM);
  ::listen(taken.descriptor(), 1);
  EXPECT_THAT(
      [&] {
        LinkRelay({.port = taken.port(), .server = {"127.0.0.1", 6720}});
      },
      ::testing::ThrowsMessage<std::runtime_error>(::testing::HasSubstr("--listen")));
  EXPECT_THAT(
      [] {
        LinkRelay({.address = "here", .server = {"127.0.0.1", 6720}});
      },
      ::testing::ThrowsMessage<std::runtime_error>(::testing::HasSubstr("--address")));
}

TEST(LinkRelay, AServerThatIsNotThereEndsTheConnection) {
  std::uint16_t port;
  {
    const testing::LocalSocket gone(SOCK_STREAM);
    port = gone.port();
  }
  Relay relay({"127.0.0.1", port}, "lan");
  EXPECT_THROW(list_scenes(relay.access(), kPatience), SessionError);
}

}  // namespace
}  // namespace feltwire::link_relay_test
