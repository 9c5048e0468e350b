#include "protocol/net/udp_socket.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <stdexcept>
#include <string>

#include "protocol/net/datagram_io.hpp"

namespace feltwire::udp_socket_test {
namespace {

class Socket {
 public:
  explicit Socket(int family) : descriptor(::socket(family, SOCK_DGRAM, 0)) {}
  ~Socket() { ::close(descriptor); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int option(int level, int name) const {
    int value = -1;
    socklen_t size = sizeof value;
    EXPECT_EQ(::getsockopt(descriptor, level, name, &value, &size), 0);
    return value;
  }
  int descriptor;
};

TEST(Dscp, NamesAndNumbers) {
  EXPECT_EQ(dscp("ef"), 46);
  EXPECT_EQ(dscp("va"), 44);
  for (int n = 0; n < 8; ++n) EXPECT_EQ(dscp("cs" + std::to_string(n)), 8 * n);
  for (int c = 1; c <= 4; ++c)  // RFC 2597: class, then drop precedence
    for (int p = 1; p <= 3; ++p)
      EXPECT_EQ(dscp("af" + std::to_string(c) + std::to_string(p)), 8 * c + 2 * p);
  EXPECT_EQ(dscp("0"), 0);
  EXPECT_EQ(dscp("63"), 63);
  for (const char* bad : {"", "64", "-1", "EF ", "cs8", "4x", "0x2e", "99999999999"}) {
    try {
      dscp(bad);
      ADD_FAILURE() << bad;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("0 to 63"));
    }
  }
}

TEST(Dscp, TheSocketSaysWhatItWasTold) {
  const Socket four(AF_INET);
  EXPECT_EQ(get_dscp(four.descriptor), 0);
  EXPECT_TRUE(set_dscp(four.descriptor, 46));
  EXPECT_EQ(get_dscp(four.descriptor), 46);
  EXPECT_EQ(four.option(IPPROTO_IP, IP_TOS), 46 << 2);
  EXPECT_FALSE(set_dscp(-1, 46));
  EXPECT_FALSE(get_dscp(-1).has_value());

  const Socket six(AF_INET6);
  if (six.descriptor < 0) GTEST_SKIP() << "this machine has no IPv6";
  EXPECT_TRUE(set_dscp(six.descriptor, 40));
  EXPECT_EQ(get_dscp(six.descriptor), 40);
  EXPECT_EQ(six.option(IPPROTO_IP, IP_TOS), 40 << 2);  // for the IPv4 packets of this socket
}

TEST(Fragments, AreForbiddenInBothFamilies) {
  const Socket four(AF_INET);
  EXPECT_TRUE(forbid_fragments(four.descriptor));
  EXPECT_EQ(four.option(IPPROTO_IP, IP_MTU_DISCOVER), IP_PMTUDISC_DO);
  EXPECT_FALSE(forbid_fragments(-1));

  const Socket six(AF_INET6);
  if (six.descriptor < 0) GTEST_SKIP() << "this machine has no IPv6";
  EXPECT_TRUE(forbid_fragments(six.descriptor));
  EXPECT_EQ(six.option(IPPROTO_IPV6, IPV6_MTU_DISCOVER), IPV6_PMTUDISC_DO);
  EXPECT_EQ(six.option(IPPROTO_IP, IP_MTU_DISCOVER), IP_PMTUDISC_DO);
}

TEST(PathMtu, IsThatOfTheWayThere) {
  sockaddr_storage there{};
  auto& four = reinterpret_cast<sockaddr_in&>(there);
  four.sin_family = AF_INET;
  four.sin_port = htons(9);
  four.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const auto mtu = path_mtu(there, sizeof four);
  ASSERT_TRUE(mtu);
  EXPECT_GE(*mtu, 576);
  EXPECT_EQ(header_bytes(there), 28u);
  there = {};
  auto& six = reinterpret_cast<sockaddr_in6&>(there);
  six.sin6_family = AF_INET6;
  EXPECT_EQ(header_bytes(there), 48u);
  ::inet_pton(AF_INET6, "::ffff:127.0.0.1", &six.sin6_addr);
  EXPECT_EQ(header_bytes(there), 28u);  // The path uses IPv4.
  EXPECT_EQ(path_mtu(sockaddr_storage{}, sizeof(sockaddr_in)), std::nullopt);
}

/// Two sockets on all addresses of this machine.
class DatagramIo : public ::testing::Test {
 protected:
  DatagramIo() {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    for (const Socket* socket : {&one_, &other_})
      EXPECT_EQ(::bind(socket->descriptor, reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
    EXPECT_TRUE(report_local_address(other_.descriptor));
  }
  static sockaddr_in at(const char* address, const Socket& socket) {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    EXPECT_EQ(::getsockname(socket.descriptor, reinterpret_cast<sockaddr*>(&own), &size), 0);
    ::inet_pton(AF_INET, address, &own.sin_addr);
    return own;
  }
  /// Waits for a datagram.
  static ssize_t receive(const Socket& socket, std::span<std::uint8_t> into, sockaddr_in& from,
                         LocalAddress& local) {
    pollfd waiting{socket.descriptor, POLLIN, 0};
    EXPECT_EQ(::poll(&waiting, 1, 20'000), 1);
    socklen_t length = sizeof from;
    const ssize_t size = receive_datagram(socket.descriptor, into,
                                          reinterpret_cast<sockaddr*>(&from), length, local);
    EXPECT_EQ(length, sizeof from);
    return size;
  }
  static std::string text(const in_addr& address) {
    std::array<char, INET_ADDRSTRLEN> room{};
    return ::inet_ntop(AF_INET, &address, room.data(), room.size());
  }

  Socket one_{AF_INET}, other_{AF_INET};
  std::array<std::uint8_t, 4> room_{};
  LocalAddress local_;
};

TEST_F(DatagramIo, AnAnswerLeavesFromWhereTheQuestionCame) {
  const std::array<std::uint8_t, 3> question = {1, 2, 3};
  const sockaddr_in to = at("127.0.0.2", other_);
  ASSERT_TRUE(send_datagram(one_.descriptor, question, reinterpret_cast<const sockaddr*>(&to),
                            sizeof to, {}));
  sockaddr_in from{};
  ASSERT_EQ(receive(other_, room_, from, local_), 3);
  EXPECT_EQ(room_, (std::array<std::uint8_t, 4>{1, 2, 3, 0}));
  EXPECT_EQ(from.sin_port, at("127.0.0.1", one_).sin_port);
  ASSERT_EQ(local_.family, AF_INET);
  EXPECT_EQ(text(local_.four), "127.0.0.2");

  const std::array<std::uint8_t, 1> answer = {4};
  ASSERT_TRUE(send_datagram(other_.descriptor, answer, reinterpret_cast<const sockaddr*>(&from),
                            sizeof from, local_));
  LocalAddress unknown;
  ASSERT_EQ(receive(one_, room_, from, unknown), 1);
  EXPECT_EQ(room_[0], 4);
  EXPECT_EQ(text(from.sin_addr), "127.0.0.2");
  EXPECT_EQ(unknown.family, AF_UNSPEC) << "this socket does not tell";
}

TEST_F(DatagramIo, DoesNotWaitAndSaysWhatFailed) {
  sockaddr_in from{};
  socklen_t length = sizeof from;
  EXPECT_LT(
      receive_datagram(one_.descriptor, room_, reinterpret_cast<sockaddr*>(&from), length, local_),
      0);
  EXPECT_EQ(errno, EAGAIN);
  const sockaddr_in to = at("127.0.0.1", other_);
  EXPECT_FALSE(send_datagram(-1, room_, reinterpret_cast<const sockaddr*>(&to), sizeof to, {}));
  EXPECT_EQ(errno, EBADF);
}

}  // namespace
}  // namespace feltwire::udp_socket_test
