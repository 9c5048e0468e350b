// All scenes share a UDP port. Each must get the datagrams of its sessions, and no others.

#include "server/scene/scene_ports.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <asio/buffer.hpp>
#include <asio/ip/tcp.hpp>
#include <cstdint>
#include <vector>

#include "tests/support/eventually.hpp"

namespace feltwire::scene_ports_test {
namespace {

using asio::ip::udp;
using ::testing::HasSubstr;

constexpr std::size_t kScenes = 3;
constexpr std::size_t kHeader = 24, kSession = 8;  // [bytes] PROTOCOL.md, "Datagrams"

std::vector<std::uint8_t> datagram(std::uint8_t session_low_byte) {
  std::vector<std::uint8_t> bytes(kHeader, 0xee);
  bytes[kSession] = session_low_byte;
  return bytes;
}

/// A client's socket, and the number of datagrams that each socket of the scenes has got.
struct Line {
  explicit Line(const asio::ip::address& address)
      : sockets(open_scene_sockets(io, address, 0, kScenes)),
        client(io, udp::endpoint(address, 0)) {
    for (auto& socket : sockets) socket.non_blocking(true);
  }
  void send(const std::vector<std::uint8_t>& bytes) {
    client.send_to(asio::buffer(bytes),
                   {client.local_endpoint().address(), sockets.front().local_endpoint().port()});
    ++sent;
    test::eventually("it has arrived", [&] { return received() == sent; });
  }
  std::size_t received() {
    std::size_t all = 0;
    for (std::size_t i = 0; i < sockets.size(); ++i) {
      std::array<std::uint8_t, 64> room{};
      std::error_code none;
      while (sockets[i].receive(asio::buffer(room), 0, none) > 0) ++got[i];
      all += got[i];
    }
    return all;
  }

  asio::io_context io;
  std::vector<udp::socket> sockets;
  udp::socket client;
  std::array<std::size_t, kScenes> got{};
  std::size_t sent = 0;
};

TEST(ScenePorts, EachSceneGetsTheDatagramsOfItsSessions) {
  for (const char* address : {"127.0.0.1", "::1"}) {
    Line line(asio::ip::make_address(address));
    for (const auto& socket : line.sockets)
      EXPECT_EQ(socket.local_endpoint(), line.sockets.front().local_endpoint());
    std::array<std::size_t, kScenes> expected{};
    for (std::uint8_t n = 0; n < 60; ++n) {
      const auto scene = static_cast<std::uint8_t>(n * n % kScenes);  // in no regular order
      ++expected.at(scene);
      line.send(datagram(scene));
    }
    EXPECT_EQ(line.got, expected) << address;
  }
}

/// Such a datagram is of no session. A scene must get it, and count it as dropped.
TEST(ScenePorts, ADatagramOfNoSceneArrivesOnce) {
  Line line(asio::ip::make_address("127.0.0.1"));
  line.send(datagram(kScenes));
  line.send(datagram(255));
  line.send({1, 2, 3});
}

TEST(ScenePorts, APortThatAnotherProgramSharesIsUsed) {
  asio::io_context io;
  const auto address = asio::ip::make_address("127.0.0.1");
  udp::socket other(io, udp::v4());
  const int on = 1;
  ASSERT_EQ(::setsockopt(other.native_handle(), SOL_SOCKET, SO_REUSEPORT, &on, sizeof on), 0);
  other.bind({address, 0});
  try {
    open_scene_sockets(io, address, other.local_endpoint().port(), kScenes);
    FAIL() << "it shares the port";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("another server may be running"));
  }
}

TEST(ScenePorts, WithoutSteeringEachSceneHasAPort) {
  asio::io_context io;
  const auto address = asio::ip::make_address("127.0.0.1");
  const auto sockets = listen_with_room(0, [&](std::uint16_t) {
    const asio::ip::tcp::acceptor control(io, {address, 0});
    return open_scene_sockets(io, address, control.local_endpoint().port() + 1u, kScenes,
                              [](udp::socket&) { return false; });
  });
  ASSERT_EQ(sockets.size(), kScenes);
  for (std::size_t i = 0; i < kScenes; ++i)
    EXPECT_EQ(sockets[i].local_endpoint().port(), sockets[0].local_endpoint().port() + i);
}

}  // namespace
}  // namespace feltwire::scene_ports_test
