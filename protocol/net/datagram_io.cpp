#include "protocol/net/datagram_io.hpp"

namespace feltwire {

ssize_t receive_datagram(int descriptor, std::span<std::uint8_t> into, sockaddr* from,
                         socklen_t& length, LocalAddress& local) noexcept {
  iovec part{into.data(), into.size()};
  LocalAddressRoom room;
  msghdr message{};
  message.msg_name = from;
  message.msg_namelen = length;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  make_room(message, room);
  const ssize_t size = ::recvmsg(descriptor, &message, MSG_DONTWAIT);
  if (size < 0) return size;
  length = message.msg_namelen;
  local = local_address(message);
  return size;
}

bool send_datagram(int descriptor, std::span<const std::uint8_t> datagram, const sockaddr* to,
                   socklen_t length, const LocalAddress& from) noexcept {
  // The casts are safe, because sendmsg() does not change its arguments.
  iovec part{const_cast<std::uint8_t*>(datagram.data()), datagram.size()};
  LocalAddressRoom room;
  msghdr message{};
  message.msg_name = const_cast<sockaddr*>(to);
  message.msg_namelen = length;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  leave_from(from, message, room);
  return ::sendmsg(descriptor, &message, MSG_DONTWAIT) >= 0;
}

}  // namespace feltwire
