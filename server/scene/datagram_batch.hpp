#pragma once
// The buffers of a DatagramExchange. Internal to datagram_exchange.cpp.

#include <sys/socket.h>

#include <array>

#include "server/scene/datagram_exchange.hpp"

namespace feltwire {

/// Wired once; an exchange only changes lengths.
struct DatagramExchange::Batch {
  static constexpr std::size_t kMost = 64;  // datagrams of one system call
  // [bytes] More than a datagram may have, so that a longer one is detected.
  static constexpr std::size_t kReceiveSize = kMaxDatagram + sizeof(std::uint64_t);

  std::size_t count = 0, next = 0;  // received, and of these the first without an answer
  alignas(std::uint64_t) std::array<std::array<std::uint8_t, kReceiveSize>, kMost> received;
  static constexpr std::size_t kMostSent = kMost + kMostSeats;
  // The answers, and one target for each of the scene's robots.
  std::array<DatagramBuffer, kMostSent> sent;
  std::array<Peer, kMost> peers;
  std::array<Peer, kMostSeats> robots;
  std::array<LocalAddressRoom, kMost> received_at;
  std::array<LocalAddressRoom, kMostSent> sent_from;
  std::array<iovec, kMost> received_parts{};
  std::array<iovec, kMostSent> sent_parts{};
  std::array<mmsghdr, kMost> incoming{};
  std::array<mmsghdr, kMostSent> outgoing{};

  Batch() {
    for (std::size_t i = 0; i < kMost; ++i) {
      received_parts[i] = {received[i].data(), kReceiveSize};
      incoming[i].msg_hdr.msg_iov = &received_parts[i];
      incoming[i].msg_hdr.msg_iovlen = 1;
      incoming[i].msg_hdr.msg_name = &peers[i].address;
    }
    for (std::size_t i = 0; i < sent.size(); ++i) {
      sent_parts[i] = {sent[i].bytes.data(), 0};
      outgoing[i].msg_hdr.msg_iov = &sent_parts[i];
      outgoing[i].msg_hdr.msg_iovlen = 1;
    }
    rearm(kMost);
  }

  /// The kernel overwrites the lengths that it was given.
  void rearm(std::size_t used) noexcept {
    for (std::size_t i = 0; i < used; ++i) {
      incoming[i].msg_hdr.msg_namelen = sizeof(sockaddr_storage);
      make_room(incoming[i].msg_hdr, received_at[i]);
    }
  }

  /// sent[at] has so many bytes now, for this receiver.
  void put(std::size_t at, std::size_t size, Peer& to) noexcept {
    sent_parts[at].iov_len = size;
    outgoing[at].msg_hdr.msg_name = &to.address;
    outgoing[at].msg_hdr.msg_namelen = to.length;
    leave_from(to.local, outgoing[at].msg_hdr, sent_from[at]);
  }
};

}  // namespace feltwire
