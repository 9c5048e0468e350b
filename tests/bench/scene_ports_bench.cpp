// scene_ports/one/N, scene_ports/each/N: a datagram from a client to its scene and the answer back,
// with N scenes, at one port or at a port a scene. Without the work of a server: the difference is
// what steering costs.

#include <benchmark/benchmark.h>

#include <array>
#include <asio/buffer.hpp>
#include <asio/ip/tcp.hpp>
#include <vector>

#include "server/scene/scene_ports.hpp"

namespace feltwire::scene_ports_bench {
namespace {

using asio::ip::udp;

constexpr std::size_t kSize = 160;   // [bytes] of a sealed sample, and about those of a reply
constexpr std::size_t kSession = 8;  // offset of the session's low byte

/// The sockets of N scenes, and a client of each.
struct Lines {
  Lines(std::size_t scenes, bool one_port) {
    const auto address = asio::ip::make_address("127.0.0.1");
    servers = listen_with_room(0, [&](std::uint16_t) {
      const asio::ip::tcp::acceptor control(io, {address, 0});
      const unsigned port = control.local_endpoint().port() + 1u;
      return one_port ? open_scene_sockets(io, address, port, scenes)
                      : open_scene_ports(io, address, port, scenes);
    });
    for (auto& server : servers)
      clients.emplace_back(io, udp::v4()).connect(server.local_endpoint());
  }
  void exchange(std::size_t scene) {
    sample[kSession] = static_cast<std::uint8_t>(scene);
    clients[scene].send(asio::buffer(sample));
    udp::endpoint from;
    servers[scene].receive_from(asio::buffer(room), from);
    servers[scene].send_to(asio::buffer(room), from);
    clients[scene].receive(asio::buffer(room));
  }
  asio::io_context io;
  std::vector<udp::socket> servers, clients;
  std::array<std::uint8_t, kSize> sample{}, room{};
};

void exchange(benchmark::State& state, bool one_port) {
  Lines lines(static_cast<std::size_t>(state.range(0)), one_port);
  std::size_t scene = 0;
  for (auto _ : state) {
    lines.exchange(scene);
    scene = (scene + 1) % lines.servers.size();
  }
}

BENCHMARK_CAPTURE(exchange, one, true)->Name("scene_ports/one")->Arg(2)->Arg(50);
BENCHMARK_CAPTURE(exchange, each, false)->Name("scene_ports/each")->Arg(2)->Arg(50);

}  // namespace
}  // namespace feltwire::scene_ports_bench
