#pragma once
// A WebSocket (RFC 6455) to a service on this machine, with reads and writes that do not wait.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"
#include "protocol/wire/datagram.hpp"

struct wslay_frame_context;

namespace feltwire {

/// No function allocates after opening.
class ServiceSocket {
 public:
  enum class ReceiveResult {
    none,     // no message by the given time
    gone,     // closed, reset, or not a WebSocket any more, or it says nothing without end
    garbled,  // a message that is longer than the buffer; the next call looks for the next one
    message
  };
  static constexpr std::size_t kMostSent = 1024;  // bytes of a text
  /// Frames that end no message: parts of one, pings, pongs. With more of them in a row the service
  /// says nothing, however much it sends, and would keep the servo busy: the socket is gone.
  static constexpr int kMostIdle = 64;
  /// [bytes] of a message that is too long, to be read over. A longer one has no end: the socket is
  /// gone.
  static constexpr std::uint64_t kMostSkipped = std::uint64_t{1} << 20U;
  using Frame = std::vector<std::uint8_t>;

  /// A connection on which the service has agreed to speak WebSocket.
  struct Connection {
    int descriptor = -1;  // of a stream socket that does not block
    std::string early;    // bytes that came with the service's answer to the handshake
  };

  /// Connects to 127.0.0.1. Throws std::runtime_error that names the error and the remedy.
  ServiceSocket(std::uint16_t port, std::size_t longest_message);
  /// Takes a connection over, and closes it in the end. Throws std::runtime_error if the system has
  /// no random numbers, with which what is sent is masked.
  ServiceSocket(Connection connection, std::size_t longest_message);
  ~ServiceSocket();
  ServiceSocket(const ServiceSocket&) = delete;
  ServiceSocket& operator=(const ServiceSocket&) = delete;

  /// False: the text could not be sent whole, and the connection is no longer usable.
  bool send(std::string_view text) noexcept;
  /// Returns the bytes of a text for post().
  Frame frame(std::string_view text);
  /// Makes one system call: async-signal-safe, for any thread.
  bool post(std::span<const std::uint8_t> frame) const noexcept;

  /// Waits for the next message until `latest` (a monotonic time). It answers pings.
  ReceiveResult receive(Nanoseconds latest) noexcept;
  /// Returns that message. It is valid until the next receive().
  std::string_view message() const noexcept { return {message_.data(), size_}; }

 private:
  struct Free {
    void operator()(wslay_frame_context* context) const noexcept;
  };
  static std::ptrdiff_t read_more(std::uint8_t* room, std::size_t size, int, void* self) noexcept;
  static std::ptrdiff_t keep(const std::uint8_t* data, std::size_t size, int, void* self) noexcept;
  static int mask(std::uint8_t* room, std::size_t size, void* self) noexcept;

  std::span<const std::uint8_t> framed(std::uint8_t opcode,
                                       std::span<const std::uint8_t> data) noexcept;
  ReceiveResult take_frames(Nanoseconds latest) noexcept;
  void take_control(std::uint8_t opcode) noexcept;

  Connection connection_;
  std::size_t early_taken_ = 0;
  std::unique_ptr<wslay_frame_context, Free> context_;
  std::vector<char> message_;  // its size is the largest message
  std::size_t size_ = 0;       // number of received bytes
  bool begun_ = false, ended_ = false, too_long_ = false, gone_ = false;
  std::uint64_t of_frame_ = 0;   // received bytes of the present frame
  std::uint64_t announced_ = 0;  // bytes of the present message, by the heads of its frames
  int idle_ = 0;                 // frames in a row that ended no message
  std::array<std::uint8_t, 125> control_{};
  std::size_t control_size_ = 0;
  std::array<std::uint8_t, kMostSent + 32> out_{};
  std::size_t out_size_ = 0;
  std::uint64_t masks_;
};

}  // namespace feltwire
