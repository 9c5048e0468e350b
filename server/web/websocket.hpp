#pragma once
// One end of a WebSocket, the server's (RFC 6455): bytes to messages and back. It has no socket.
// wslay handles the frames.

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

struct wslay_event_context;

namespace feltwire {

/// The reason of a closed connection: a code of RFC 6455, or one of the page's own (4000 and
/// above).
enum class WebSocketClose : std::uint16_t {
  going_away = 1001,
  bad_message = 4400,
  bad_token = 4401,
  too_many = 4429
};

class WebSocket {
 public:
  /// `take` gets every text message. Binary messages, and messages longer than `most` [bytes],
  /// close the connection.
  WebSocket(std::size_t most, std::function<void(std::string_view)> take);
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Takes bytes from the other end. Answers pings and closes. False: they are not bytes of a
  /// WebSocket, and nothing more should be read. Passes on the exceptions of `take`.
  bool receive(std::span<const std::uint8_t> bytes);
  /// Throws std::bad_alloc. Nothing happens after close().
  void send_text(std::string_view message) { send(false, {bytes_of(message), message.size()}); }
  void send_binary(std::span<const std::uint8_t> message) { send(true, message); }
  /// Sends a close with its reason; at most 120 bytes of the reason are sent.
  void close(WebSocketClose code, std::string_view reason);
  /// Whether both ends have closed.
  bool closed() const noexcept;

  /// Moves out the bytes to send to the other end.
  std::vector<std::uint8_t> take_output();
  bool has_output() const noexcept;

 private:
  static const std::uint8_t* bytes_of(std::string_view text) {
    return reinterpret_cast<const std::uint8_t*>(text.data());
  }
  void send(bool binary, std::span<const std::uint8_t> message);
  struct Callbacks;
  struct Free {
    void operator()(wslay_event_context* context) const noexcept;
  };

  std::function<void(std::string_view)> take_;
  std::unique_ptr<wslay_event_context, Free> context_;
  std::span<const std::uint8_t> input_;  // the bytes that are read now
  std::vector<std::uint8_t> output_;
  std::exception_ptr failure_;  // thrown in a callback of C code
};

}  // namespace feltwire
