#include "server/web/websocket.hpp"

#include <wslay/wslay.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <utility>

namespace feltwire {
namespace {

constexpr std::size_t kAtOnce = 16384;  // [bytes] limit on messages that are written together
constexpr std::size_t kShort = 4096;    // [bytes] largest shared message that is copied

/// Appends the head of a message that is one frame (RFC 6455, 5.2). A server does not mask its
/// frames.
void append_head(std::vector<std::uint8_t>& bytes, std::uint8_t opcode, std::size_t size) {
  constexpr std::uint8_t kWhole = 0x80, kTwoBytes = 126, kEightBytes = 127;
  constexpr std::size_t kMostOfTwo = 65535;
  bytes.push_back(static_cast<std::uint8_t>(kWhole | opcode));
  int more = 0;
  if (size < kTwoBytes) {
    bytes.push_back(static_cast<std::uint8_t>(size));
  } else {
    more = size <= kMostOfTwo ? 2 : 8;
    bytes.push_back(more == 2 ? kTwoBytes : kEightBytes);
  }
  while (more-- > 0) bytes.push_back(static_cast<std::uint8_t>(std::uint64_t{size} >> 8 * more));
}

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

void append(std::vector<std::uint8_t>& bytes, std::span<const std::uint8_t> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

}  // namespace

/// The functions that wslay calls. They must not throw, because wslay is a C library.
struct WebSocket::Callbacks {
  static ssize_t receive(wslay_event_context* context, std::uint8_t* to, std::size_t most, int,
                         void* user) {
    auto& self = *static_cast<WebSocket*>(user);
    if (self.input_.empty()) {
      wslay_event_set_error(context, WSLAY_ERR_WOULDBLOCK);
      return -1;
    }
    const std::size_t count = std::min(most, self.input_.size());
    std::memcpy(to, self.input_.data(), count);
    self.input_ = self.input_.subspan(count);
    return static_cast<ssize_t>(count);
  }

  static ssize_t send(wslay_event_context* context, const std::uint8_t* bytes, std::size_t count,
                      int, void* user) {
    auto& self = *static_cast<WebSocket*>(user);
    try {
      append(self.control_, {bytes, count});
    } catch (...) {
      self.failure_ = std::current_exception();
      wslay_event_set_error(context, WSLAY_ERR_NOMEM);
      return -1;
    }
    return static_cast<ssize_t>(count);
  }

  static void frame(wslay_event_context*, const wslay_event_on_frame_recv_start_arg*, void* user) {
    auto& self = *static_cast<WebSocket*>(user);
    if (!self.begun_ || self.closing_ || self.failure_ != nullptr) return;
    try {
      self.begun_();
    } catch (...) {
      self.failure_ = std::current_exception();
    }
  }

  static void message(wslay_event_context*, const wslay_event_on_msg_recv_arg* message,
                      void* user) {
    auto& self = *static_cast<WebSocket*>(user);
    if (wslay_is_ctrl_frame(message->opcode) || self.closing_ || self.failure_ != nullptr) return;
    try {
      if (message->opcode != WSLAY_TEXT_FRAME)
        self.close(WebSocketClose::bad_message, "only text is read");
      else
        self.take_({reinterpret_cast<const char*>(message->msg), message->msg_length});
    } catch (...) {
      self.failure_ = std::current_exception();
    }
  }
};

void WebSocket::Free::operator()(wslay_event_context* context) const noexcept {
  wslay_event_context_free(context);
}

WebSocket::WebSocket(std::size_t most, std::function<void(std::string_view)> take,
                     std::function<void()> begun)
    : take_(std::move(take)), begun_(std::move(begun)) {
  wslay_event_callbacks callbacks{};
  callbacks.recv_callback = Callbacks::receive;
  callbacks.send_callback = Callbacks::send;
  callbacks.on_frame_recv_start_callback = Callbacks::frame;
  callbacks.on_msg_recv_callback = Callbacks::message;
  wslay_event_context* context = nullptr;
  if (wslay_event_context_server_init(&context, &callbacks, this) != 0) throw std::bad_alloc();
  context_.reset(context);
  wslay_event_config_set_max_recv_msg_length(context, most);
}

WebSocket::~WebSocket() = default;

bool WebSocket::receive(std::span<const std::uint8_t> bytes) {
  input_ = bytes;
  const int failed = wslay_event_recv(context_.get());
  input_ = {};
  if (failure_ != nullptr) std::rethrow_exception(std::exchange(failure_, nullptr));
  return failed == 0;
}

bool WebSocket::reads() const noexcept {
  return !closing_ && wslay_event_get_read_enabled(context_.get()) != 0;
}

void WebSocket::send_text(std::string_view message) {
  queue(WSLAY_TEXT_FRAME, bytes_of(message), {});
}

void WebSocket::send_text(const web::SharedBytes& message) { queue(WSLAY_TEXT_FRAME, {}, message); }

void WebSocket::send_binary(const web::SharedBytes& message, std::span<const std::uint8_t> head) {
  queue(WSLAY_BINARY_FRAME, head, message);
}

void WebSocket::ping() {
  if (closing_ || wslay_event_get_write_enabled(context_.get()) == 0) return;
  const wslay_event_msg ping{WSLAY_PING, nullptr, 0};
  if (wslay_event_queue_msg(context_.get(), &ping) == WSLAY_ERR_NOMEM) throw std::bad_alloc();
}

void WebSocket::queue(std::uint8_t opcode, std::span<const std::uint8_t> own,
                      const web::SharedBytes& shared) {
  if (closing_ || wslay_event_get_write_enabled(context_.get()) == 0) return;
  constexpr std::size_t kLongestHead = 10;
  Message message;
  message.own.reserve(kLongestHead + own.size());
  append_head(message.own, opcode, own.size() + shared.size());
  append(message.own, own);
  message.shared = shared;
  messages_.push_back(std::move(message));
  own_ += messages_.back().own.size();
}

void WebSocket::drop_messages() noexcept {
  messages_.clear();
  own_ = 0;
}

void WebSocket::close(WebSocketClose code, std::string_view reason) {
  constexpr std::size_t kMostReason = 120;  // [bytes] of the reason; a close frame has room for 123
  reason = reason.substr(0, kMostReason);
  if (wslay_event_queue_close(context_.get(), static_cast<std::uint16_t>(code),
                              bytes_of(reason).data(), reason.size()) == WSLAY_ERR_NOMEM)
    throw std::bad_alloc();
  closing_ = true;
  wslay_event_config_set_no_buffering(context_.get(), 1);  // store no further bytes of messages
  drop_messages();
}

bool WebSocket::closed() const noexcept {
  return wslay_event_get_close_sent(context_.get()) != 0 &&
         wslay_event_get_close_received(context_.get()) != 0;
}

bool WebSocket::has_output() const noexcept {
  return !messages_.empty() || !control_.empty() || wslay_event_want_write(context_.get()) != 0;
}

std::size_t WebSocket::waiting() const noexcept {
  return own_ + control_.size() + wslay_event_get_queued_msg_length(context_.get());
}

web::Output WebSocket::take_output() {
  const int failed = wslay_event_send(context_.get());
  if (failure_ != nullptr) std::rethrow_exception(std::exchange(failure_, nullptr));
  if (failed == WSLAY_ERR_NOMEM) throw std::bad_alloc();
  web::Output output{std::exchange(control_, {}), {}};
  // Nothing may follow a close frame. wslay may also send one by itself.
  if (wslay_event_get_write_enabled(context_.get()) == 0) drop_messages();
  while (!messages_.empty() && output.own.size() < kAtOnce && output.shared.empty()) {
    Message& next = messages_.front();
    append(output.own, next.own);
    if (next.shared.size() <= kShort)
      append(output.own, next.shared.bytes());
    else
      output.shared = std::move(next.shared);
    own_ -= next.own.size();
    messages_.pop_front();
  }
  return output;
}

}  // namespace feltwire
