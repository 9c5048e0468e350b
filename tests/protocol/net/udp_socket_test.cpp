#include "protocol/net/udp_socket.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

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
  EXPECT_EQ(six.option(IPPROTO_IP, IP_TOS), 40 << 2);  // of the IPv4 that it may carry
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

}  // namespace
}  // namespace feltwire::udp_socket_test
