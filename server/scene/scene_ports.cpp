#include "server/scene/scene_ports.hpp"

#include <linux/filter.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <array>
#include <system_error>

namespace feltwire {
namespace {

constexpr std::uint32_t kSessionOffset = 8;  // [bytes] of the session's low byte in a datagram

asio::ip::udp::socket unbound(asio::io_context& io, const asio::ip::address& address) {
  asio::ip::udp::socket socket(io);
  socket.open(asio::ip::udp::endpoint(address, 0).protocol());
  serve_both_families(socket, address);
  return socket;
}

bool share_port(asio::ip::udp::socket& socket) {
  const int on = 1;
  return ::setsockopt(socket.native_handle(), SOL_SOCKET, SO_REUSEPORT, &on, sizeof on) == 0;
}

/// Binds `count` sockets to one port, and steers their datagrams. Returns none if the kernel cannot
/// do that. Only the first socket is bound alone, so that a port that another program shares counts
/// as used.
std::vector<asio::ip::udp::socket> open_group(asio::io_context& io,
                                              asio::ip::udp::endpoint endpoint, std::size_t count,
                                              bool (*steer)(asio::ip::udp::socket&)) {
  std::vector<asio::ip::udp::socket> sockets;
  for (std::size_t i = 0; i < count; ++i) {
    auto& socket = sockets.emplace_back(unbound(io, endpoint.address()));
    if (i > 0 && !share_port(socket)) return {};
    socket.bind(endpoint);
    if (i == 0 && !share_port(socket)) return {};
    endpoint.port(socket.local_endpoint().port());
  }
  if (!steer(sockets.front())) return {};
  return sockets;
}

}  // namespace

std::vector<asio::ip::udp::socket> open_scene_ports(asio::io_context& io,
                                                    const asio::ip::address& address,
                                                    unsigned first, std::size_t count,
                                                    const char* port_option) {
  std::vector<asio::ip::udp::socket> sockets;
  for (std::size_t i = 0; i < count; ++i) {
    const auto port = static_cast<std::uint16_t>(first + i);
    try {
      if (first + i > 65535) throw std::system_error(EADDRINUSE, std::generic_category());
      sockets.push_back(unbound(io, address));
      sockets.back().bind({address, port});
    } catch (const std::system_error& error) {
      throw listen_error("udp", address, port, error.code(), port_option);
    }
  }
  return sockets;
}

bool steer_by_session(asio::ip::udp::socket& one_of_them) {
  std::array<sock_filter, 2> code = {{
      {BPF_LD | BPF_B | BPF_ABS, 0, 0, kSessionOffset},
      {BPF_RET | BPF_A, 0, 0, 0},
  }};
  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  return ::setsockopt(one_of_them.native_handle(), SOL_SOCKET, SO_ATTACH_REUSEPORT_CBPF, &program,
                      sizeof program) == 0;
}

std::vector<asio::ip::udp::socket> open_scene_sockets(asio::io_context& io,
                                                      const asio::ip::address& address,
                                                      unsigned port, std::size_t count,
                                                      bool (*steer)(asio::ip::udp::socket&)) {
  if (count < 2 || port > 65535) return open_scene_ports(io, address, port, count);
  const auto shared = static_cast<std::uint16_t>(port);
  try {
    auto sockets = open_group(io, {address, shared}, count, steer);
    if (!sockets.empty()) return sockets;
  } catch (const std::system_error& error) {
    throw listen_error("udp", address, shared, error.code());
  }
  spdlog::warn(
      "the kernel steers no datagrams to the sockets of one port, so each scene has a UDP "
      "port of its own, from {} on",
      port);
  return open_scene_ports(io, address, port, count);
}

}  // namespace feltwire
