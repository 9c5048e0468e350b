#include "server/web/websocket.hpp"

#include <wslay/wslay.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <utility>

namespace feltwire {

/// Called by wslay, which is C: nothing may be thrown through it.
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
      self.output_.insert(self.output_.end(), bytes, bytes + count);
    } catch (...) {
      self.failure_ = std::current_exception();
      wslay_event_set_error(context, WSLAY_ERR_NOMEM);
      return -1;
    }
    return static_cast<ssize_t>(count);
  }

  static void message(wslay_event_context*, const wslay_event_on_msg_recv_arg* message,
                      void* user) {
    auto& self = *static_cast<WebSocket*>(user);
    if (wslay_is_ctrl_frame(message->opcode) || self.failure_ != nullptr) return;
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

WebSocket::WebSocket(std::size_t most, std::function<void(std::string_view)> take)
    : take_(std::move(take)) {
  wslay_event_callbacks callbacks{};
  callbacks.recv_callback = Callbacks::receive;
  callbacks.send_callback = Callbacks::send;
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

void WebSocket::send(bool binary, std::span<const std::uint8_t> message) {
  const wslay_event_msg queued{
      static_cast<std::uint8_t>(binary ? WSLAY_BINARY_FRAME : WSLAY_TEXT_FRAME), message.data(),
      message.size()};
  if (wslay_event_queue_msg(context_.get(), &queued) == WSLAY_ERR_NOMEM) throw std::bad_alloc();
}

void WebSocket::close(WebSocketClose code, std::string_view reason) {
  constexpr std::size_t kMostReason = 120;  // a control frame holds 123
  reason = reason.substr(0, kMostReason);
  if (wslay_event_queue_close(context_.get(), static_cast<std::uint16_t>(code), bytes_of(reason),
                              reason.size()) == WSLAY_ERR_NOMEM)
    throw std::bad_alloc();
}

bool WebSocket::closed() const noexcept {
  return wslay_event_get_close_sent(context_.get()) != 0 &&
         wslay_event_get_close_received(context_.get()) != 0;
}

bool WebSocket::has_output() const noexcept {
  return !output_.empty() || wslay_event_want_write(context_.get()) != 0;
}

std::vector<std::uint8_t> WebSocket::take_output() {
  const int failed = wslay_event_send(context_.get());
  if (failure_ != nullptr) std::rethrow_exception(std::exchange(failure_, nullptr));
  if (failed == WSLAY_ERR_NOMEM) throw std::bad_alloc();
  return std::exchange(output_, {});
}

}  // namespace feltwire
