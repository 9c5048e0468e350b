#pragma once
// One control connection through the relay: two TCP connections, and the ports in the answers
// replaced.

#include <array>
#include <asio/ip/tcp.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace feltwire {

class ControlBridge : public std::enable_shared_from_this<ControlBridge> {
 public:
  /// The relay's UDP port that stands for the server's. May throw std::runtime_error; the
  /// connection then ends.
  using MapPort = std::function<std::uint16_t(std::uint16_t)>;

  ControlBridge(asio::ip::tcp::socket client, MapPort map_port)
      : client_(std::move(client)), server_(client_.get_executor()), map_(std::move(map_port)) {}

  /// Connects and relays until one side ends.
  void start(const asio::ip::tcp::endpoint& server);

 private:
  void requests();
  void answers();
  void answer(std::size_t size);
  void pass_on(std::vector<std::uint8_t> frame);
  void close();

  asio::ip::tcp::socket client_, server_;
  MapPort map_;
  std::array<std::uint8_t, 4096> request_{};
  std::array<std::uint8_t, 4> length_{};
  std::vector<std::uint8_t> body_, frame_;
};

}  // namespace feltwire
