#include "protocol/net/udp_socket.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <stdexcept>
#include <utility>

#include "protocol/net/local_address.hpp"

namespace feltwire {
namespace {

constexpr std::array<std::pair<std::string_view, int>, 22> kCodePoints = {{
    {"cs0", 0},   {"cs1", 8},   {"cs2", 16},  {"cs3", 24},  {"cs4", 32},  {"cs5", 40},
    {"cs6", 48},  {"cs7", 56},  {"af11", 10}, {"af12", 12}, {"af13", 14}, {"af21", 18},
    {"af22", 20}, {"af23", 22}, {"af31", 26}, {"af32", 28}, {"af33", 30}, {"af41", 34},
    {"af42", 36}, {"af43", 38}, {"ef", 46},   {"va", 44},
}};
// The DSCP code point is above the two bits of explicit congestion notification (ECN).
constexpr int kEcnBits = 2;

bool set(int descriptor, int level, int option, int value) noexcept {
  return ::setsockopt(descriptor, level, option, &value, sizeof value) == 0;
}

}  // namespace

int dscp(std::string_view text) {
  for (const auto& [name, value] : kCodePoints)
    if (text == name) return value;
  int number = -1;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && rest == text.data() + text.size() && number >= 0 &&
      number <= kMaxDscp)
    return number;
  throw std::invalid_argument("'" + std::string(text) +
                              "' is no DSCP; use cs0 to cs7, af11 to af43, ef, va or a number "
                              "from 0 to 63");
}

bool set_dscp(int descriptor, int dscp) noexcept {
  const int field = dscp << kEcnBits;
  // An IPv6 socket may also carry IPv4, so set both options.
  const bool six = family_of(descriptor) == AF_INET6;
  if (six && !set(descriptor, IPPROTO_IPV6, IPV6_TCLASS, field)) return false;
  return set(descriptor, IPPROTO_IP, IP_TOS, field) || six;
}

std::optional<int> get_dscp(int descriptor) noexcept {
  int field = 0;
  socklen_t size = sizeof field;
  const bool six = family_of(descriptor) == AF_INET6;
  const int got = six ? ::getsockopt(descriptor, IPPROTO_IPV6, IPV6_TCLASS, &field, &size)
                      : ::getsockopt(descriptor, IPPROTO_IP, IP_TOS, &field, &size);
  if (got != 0) return std::nullopt;
  return field >> kEcnBits;
}

bool forbid_fragments(int descriptor) noexcept {
  const bool six = family_of(descriptor) == AF_INET6;
  if (six && !set(descriptor, IPPROTO_IPV6, IPV6_MTU_DISCOVER, IPV6_PMTUDISC_DO)) return false;
  return set(descriptor, IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_DO) || six;
}

std::optional<int> path_mtu(const sockaddr_storage& to, socklen_t size) noexcept {
  const bool six = to.ss_family == AF_INET6;
  const int descriptor = ::socket(to.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return std::nullopt;
  int mtu = 0;
  socklen_t length = sizeof mtu;
  // Connect the socket, because only a connected socket has the MTU of its path.
  const auto ask = [&](int level, int option) {
    return ::getsockopt(descriptor, level, option, &mtu, &length) == 0;
  };
  const bool known =
      ::connect(descriptor, reinterpret_cast<const sockaddr*>(&to), size) == 0 &&
      (six ? ask(IPPROTO_IPV6, IPV6_MTU) || ask(IPPROTO_IP, IP_MTU) : ask(IPPROTO_IP, IP_MTU));
  ::close(descriptor);
  return known ? std::optional<int>(mtu) : std::nullopt;
}

std::size_t header_bytes(const sockaddr_storage& to) noexcept {
  constexpr std::size_t kFour = 20, kSix = 40, kUdp = 8;
  const auto& six = reinterpret_cast<const sockaddr_in6&>(to);
  const bool is_six = to.ss_family == AF_INET6 && !IN6_IS_ADDR_V4MAPPED(&six.sin6_addr);
  return kUdp + (is_six ? kSix : kFour);
}

}  // namespace feltwire
