#include "protocol/net/local_address.hpp"

#include <cstring>

namespace feltwire {
namespace {

/// Makes the control data of a message, with a single entry.
template <class Info>
void put(msghdr& message, LocalAddressRoom& room, int level, int type, const Info& info) noexcept {
  room.bytes = {};
  message.msg_control = room.bytes.data();
  message.msg_controllen = CMSG_SPACE(sizeof info);
  cmsghdr* const entry = CMSG_FIRSTHDR(&message);
  entry->cmsg_level = level;
  entry->cmsg_type = type;
  entry->cmsg_len = CMSG_LEN(sizeof info);
  std::memcpy(CMSG_DATA(entry), &info, sizeof info);
}

}  // namespace

int family_of(int descriptor) noexcept {
  int value = AF_UNSPEC;
  socklen_t size = sizeof value;
  ::getsockopt(descriptor, SOL_SOCKET, SO_DOMAIN, &value, &size);
  return value;
}

bool report_local_address(int descriptor) noexcept {
  const int on = 1;
  // An IPv6 socket that also takes IPv4 reports both kinds of addresses through this one option.
  return family_of(descriptor) == AF_INET6
             ? ::setsockopt(descriptor, IPPROTO_IPV6, IPV6_RECVPKTINFO, &on, sizeof on) == 0
             : ::setsockopt(descriptor, IPPROTO_IP, IP_PKTINFO, &on, sizeof on) == 0;
}

void make_room(msghdr& message, LocalAddressRoom& room) noexcept {
  message.msg_control = room.bytes.data();
  message.msg_controllen = room.bytes.size();
}

LocalAddress local_address(const msghdr& message) noexcept {
  LocalAddress local;
  if (message.msg_controllen == 0) return local;
  // The cast is safe, because CMSG_NXTHDR only reads the message.
  auto* own = const_cast<msghdr*>(&message);
  for (cmsghdr* entry = CMSG_FIRSTHDR(own); entry != nullptr; entry = CMSG_NXTHDR(own, entry)) {
    if (entry->cmsg_level == IPPROTO_IP && entry->cmsg_type == IP_PKTINFO) {
      in_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(entry), sizeof info);
      local.family = AF_INET;
      local.four = info.ipi_spec_dst;  // address of the interface, also for a broadcast
    } else if (entry->cmsg_level == IPPROTO_IPV6 && entry->cmsg_type == IPV6_PKTINFO) {
      in6_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(entry), sizeof info);
      if (IN6_IS_ADDR_MULTICAST(&info.ipi6_addr)) continue;
      local.family = AF_INET6;
      local.six = info.ipi6_addr;
      // Only a link-local address needs its interface. A reply to any other address may leave
      // through another interface.
      if (IN6_IS_ADDR_LINKLOCAL(&info.ipi6_addr)) local.interface = info.ipi6_ifindex;
    }
  }
  return local;
}

void leave_from(const LocalAddress& from, msghdr& message, LocalAddressRoom& room) noexcept {
  if (from.family == AF_INET6) {
    put(message, room, IPPROTO_IPV6, IPV6_PKTINFO,
        in6_pktinfo{.ipi6_addr = from.six, .ipi6_ifindex = from.interface});
  } else if (from.family == AF_INET) {
    put(message, room, IPPROTO_IP, IP_PKTINFO,
        in_pktinfo{.ipi_ifindex = 0, .ipi_spec_dst = from.four, .ipi_addr = {}});
  } else {
    message.msg_control = nullptr;
    message.msg_controllen = 0;
  }
}

}  // namespace feltwire
