#pragma once
// A control connection through the relay: two TCP connections, and bytes between them. They are
// sealed from end to end (TLS), so the relay can neither read nor change them.

#include <array>
#include <asio/ip/tcp.hpp>
#include <cstdint>
#include <memory>

namespace feltwire {

class ControlBridge : public std::enable_shared_from_this<ControlBridge> {
 public:
  explicit ControlBridge(asio::ip::tcp::socket client)
      : client_(std::move(client)), server_(client_.get_executor()) {}

  /// Connects and relays until both sides have ended.
  void start(const asio::ip::tcp::endpoint& server);

 private:
  using Buffer = std::array<std::uint8_t, 4096>;
  void pass_on(asio::ip::tcp::socket& from, asio::ip::tcp::socket& to, Buffer& buffer);
  void close();

  asio::ip::tcp::socket client_, server_;
  Buffer up_{}, down_{};
};

}  // namespace feltwire
