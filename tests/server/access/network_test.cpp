// A whole server on the network's own terms: both families, marks, clients that do not read.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "protocol/net/udp_socket.hpp"
#include "server/app/server.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire::network_test {
namespace {

using test::ControlClient;
using test::RawSocket;

ServerConfig listening(const char* address) {
  ServerConfig config = test::any_port();
  config.address = address;
  return config;
}

std::vector<Scene> room() {
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  return scenes;
}

/// Null where this machine has no IPv6.
std::unique_ptr<Server> serve_six(const char* address) {
  try {
    return std::make_unique<Server>(listening(address), room(), test::security());
  } catch (const std::runtime_error&) {
    return nullptr;
  }
}

/// Joins and has samples answered; the last answer.
Reply feel(const Server& server, int family) {
  ControlClient control(server.control_port(), family);
  const auto joined = control.join(test::join_request());
  RawSocket datagrams(SOCK_DGRAM, joined.udp_port, family);
  const SessionKeys keys = joined.keys;
  test::SealedEncoder encoder(test::Way::up, keys);
  Reply reply;
  for (std::uint64_t n = 1; n <= 20; ++n) {
    datagrams.send(encoder.samples(joined.accepted.session, n, test::hand_batch(n)));
    const auto bytes = datagrams.receive();
    EXPECT_EQ(decode(test::opened(bytes, test::Way::down, keys), reply), DropReason::none);
    EXPECT_EQ(reply.sample_index, n);
  }
  return reply;
}

TEST(Network, ServesIpv6) {
  const auto server = serve_six("::1");
  if (!server) GTEST_SKIP() << "this machine has no IPv6";
  EXPECT_EQ(feel(*server, AF_INET6).sample_index, 20u);
}

TEST(Network, EveryNetworkIsBothFamilies) {
  const auto server = serve_six("::");
  if (!server) GTEST_SKIP() << "this machine has no IPv6";
  const Reply six = feel(*server, AF_INET6), four = feel(*server, AF_INET);
  EXPECT_EQ(six.command.elastic, four.command.elastic);
}

/// The mark of the next datagram, as it arrives; -1: none came with it.
int mark_of_next(int descriptor, int family) {
  std::array<std::uint8_t, kMaxDatagram> bytes;
  alignas(cmsghdr) std::array<char, 64> control;
  iovec part{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  pollfd waiting{descriptor, POLLIN, 0};
  if (::poll(&waiting, 1, test::kPatience) != 1 || ::recvmsg(descriptor, &message, 0) < 0)
    return -1;
  for (const cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr;
       c = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(c))) {
    if (family == AF_INET && c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_TOS)
      return *CMSG_DATA(c) >> 2;
    if (family == AF_INET6 && c->cmsg_level == IPPROTO_IPV6 && c->cmsg_type == IPV6_TCLASS)
      return *CMSG_DATA(c) >> 2;
  }
  return -1;
}

int mark_of_reply(const Server& server, int family) {
  ControlClient control(server.control_port(), family);
  const auto joined = control.join(test::join_request());
  RawSocket datagrams(SOCK_DGRAM, joined.udp_port, family);
  const int on = 1;
  const bool four = family == AF_INET;
  EXPECT_EQ(::setsockopt(datagrams.descriptor(), four ? IPPROTO_IP : IPPROTO_IPV6,
                         four ? IP_RECVTOS : IPV6_RECVTCLASS, &on, sizeof on),
            0);
  test::SealedEncoder encoder(test::Way::up, joined.keys);
  datagrams.send(encoder.samples(joined.accepted.session, 1, test::hand_batch(1)));
  return mark_of_next(datagrams.descriptor(), family);
}

TEST(Network, RepliesAreMarked) {
  for (const auto& [name, value] : {std::pair{"ef", 46}, {"cs5", 40}, {"17", 17}, {"cs0", 0}}) {
    ServerConfig config = listening("127.0.0.1");
    config.dscp = name;
    const Server server(config, room(), test::security());
    EXPECT_EQ(mark_of_reply(server, AF_INET), value) << name;
  }
}

TEST(Network, RepliesAreMarkedInBothFamilies) {
  ServerConfig config = listening("::");
  config.dscp = "ef";
  try {
    const Server server(config, room(), test::security());
    EXPECT_EQ(mark_of_reply(server, AF_INET6), 46);
    EXPECT_EQ(mark_of_reply(server, AF_INET), 46);
  } catch (const std::runtime_error&) {
    GTEST_SKIP() << "this machine has no IPv6";
  }
}

/// Its replies pile up in its own socket and are lost there; its neighbour has each of his.
TEST(Network, AClientThatNeverReadsHarmsNobodyElse) {
  ServerConfig config = listening("127.0.0.1");
  config.sample_rate_limit = 1e3;  // as fast as it goes
  Server server(config, room(), test::security());
  ControlClient control(server.control_port());
  const auto deaf = control.join(test::join_request());
  const auto joined = control.join(test::join_request());
  RawSocket unread(SOCK_DGRAM, deaf.udp_port), datagrams(SOCK_DGRAM, joined.udp_port);
  const SessionKeys keys = joined.keys;
  test::SealedEncoder deafs(test::Way::up, deaf.keys), encoder(test::Way::up, keys);
  std::uint64_t sent = 0;
  for (std::uint64_t n = 1; n <= 500; ++n) {
    for (int k = 0; k < 10; ++k) {
      ++sent;
      unread.send(deafs.samples(deaf.accepted.session, sent, test::hand_batch(sent)));
    }
    datagrams.send(encoder.samples(joined.accepted.session, n, test::hand_batch(n)));
    Reply reply;
    ASSERT_EQ(decode(test::opened(datagrams.receive(), test::Way::down, keys), reply),
              DropReason::none);
    ASSERT_EQ(reply.sample_index, n);
  }
  server.stop();
  EXPECT_EQ(server.summary()[0].counters.samples.replies, sent + 500);
}

}  // namespace
}  // namespace feltwire::network_test
