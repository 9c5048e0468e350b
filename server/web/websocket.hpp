#pragma once
// The server's end of a WebSocket (RFC 6455): bytes to messages and back. It has no socket.
// wslay handles the frames.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "server/web/shared_bytes.hpp"

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
  /// close the connection. `begun` is called at the beginning of each frame of the other end,
  /// before anything is stored for it: of a message, of a part of one, of a ping, of a pong, of a
  /// close. It may close(). After close() neither is called, and nothing more is stored of
  /// messages.
  WebSocket(std::size_t most, std::function<void(std::string_view)> take,
            std::function<void()> begun = {});
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Takes bytes from the other end. Answers pings and closes. False: they are not bytes of a
  /// WebSocket, and nothing more should be read. Passes on the exceptions of `take` and `begun`.
  bool receive(std::span<const std::uint8_t> bytes);
  /// Whether messages may come: false after close(), after a close of the other end, and after it
  /// has broken a rule.
  bool reads() const noexcept;
  /// Throws std::bad_alloc. Nothing happens after close().
  void send_text(std::string_view message);
  /// Sends a message that other connections send, too; it is not copied. A binary message may begin
  /// with bytes of this connection only, `head`.
  void send_text(const web::SharedBytes& message);
  void send_binary(const web::SharedBytes& message, std::span<const std::uint8_t> head = {});
  /// Sends a ping, which the other end answers. Throws std::bad_alloc. Nothing happens after
  /// close().
  void ping();
  /// Sends a close with its reason; at most 120 bytes of the reason are sent. Messages of which no
  /// byte was taken out are dropped.
  void close(WebSocketClose code, std::string_view reason);
  /// Whether both ends have closed.
  bool closed() const noexcept;

  /// Moves out the next bytes to send to the other end: several short messages, or one long one.
  web::Output take_output();
  bool has_output() const noexcept;
  /// [bytes] that only this connection stores until they are taken out.
  std::size_t waiting() const noexcept;

 private:
  struct Message {
    std::vector<std::uint8_t> own;  // the frame's head, and the bytes of this connection only
    web::SharedBytes shared;
  };
  struct Callbacks;
  struct Free {
    void operator()(wslay_event_context* context) const noexcept;
  };
  void queue(std::uint8_t opcode, std::span<const std::uint8_t> own,
             const web::SharedBytes& shared);
  void drop_messages() noexcept;

  std::function<void(std::string_view)> take_;
  std::function<void()> begun_;
  std::unique_ptr<wslay_event_context, Free> context_;
  std::span<const std::uint8_t> input_;  // the bytes that are read now
  std::deque<Message> messages_;         // to send
  std::size_t own_ = 0;                  // [bytes] of messages_
  std::vector<std::uint8_t> control_;    // pongs and a close to send
  bool closing_ = false;
  std::exception_ptr failure_;  // thrown in a callback of C code
};

}  // namespace feltwire
