#include "server/web/connection.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "server/web/answers.hpp"

namespace feltwire::web {
namespace {

constexpr std::chrono::seconds kWriteTime{10};  // for what a viewer is sent at once
constexpr std::chrono::seconds kCloseTime{2};   // for its answer to a close

}  // namespace

WebServer::Connection::Connection(WebServer& server, Places::Id id, std::unique_ptr<Stream> stream,
                                  const asio::ip::address& address)
    : server_(server),
      id_(id),
      address_(address),
      stream_(std::move(stream)),
      deadline_(server.io_) {}

/// A handler that keeps this connection, does nothing once it has ended, and ends it, and nothing
/// else, when `work` throws.
template <class Work>
auto WebServer::Connection::safely(Work work) {
  return [self = shared_from_this(), work = std::move(work)](const auto&... results) {
    if (self->ended_) return;
    try {
      work(results...);
    } catch (const std::exception& error) {
      spdlog::error("live page: a connection from {} ends, the server failed at it: {}",
                    self->address_.to_string(), error.what());
      self->end();
    }
  };
}

void WebServer::Connection::set_deadline(std::chrono::milliseconds patience) {
  deadline_.expires_after(patience);
  deadline_.async_wait(safely([this](const std::error_code& cancelled) {
    if (!cancelled) end();
  }));
}

void WebServer::Connection::end() noexcept {
  if (ended_) return;
  ended_ = true;
  stream_->close();
  deadline_.cancel();
  if (seat_) server_.audience_.leave(*seat_);
  server_.places_.leave(id_);
  server_.connections_.erase(id_);
  server_.leave_if_empty();
}

void WebServer::Connection::start() {
  set_deadline(server_.options_.patience);
  stream_->handshake(safely([this](const std::error_code& error) {
    if (error) return end();
    read_head();
  }));
}

void WebServer::Connection::read_head() {
  stream_->read(safely([this](const std::error_code& error, std::span<const std::uint8_t> bytes) {
    if (error) return end();
    head_.append(bytes.begin(), bytes.end());
    if (const auto length = http_head_length(head_)) return answer_head(*length);
    if (head_.size() <= kMaxHttpHead) return read_head();
    write_last(answer(nullptr, {}).bytes);
  }));
}

void WebServer::Connection::answer_head(std::size_t length) {
  const auto request = parse_http_head(std::string_view(head_).substr(0, length));
  Answer answered = answer(request ? &*request : nullptr, server_.site(address_));
  if (!answered.upgraded) return write_last(std::move(answered.bytes));
  head_.erase(0, length);
  become_viewer(std::move(answered));
}

void WebServer::Connection::become_viewer(Answer accepted) {
  socket_ = std::make_unique<WebSocket>(Audience::kMostMessage, [this](std::string_view message) {
    if (seat_) server_.audience_.receive(*seat_, message);
  });
  writing_ = true;
  stream_->write(
      std::move(accepted.bytes),
      safely([this, ticket = accepted.ticket](const std::error_code& error) {
        writing_ = false;
        if (error) return end();
        seat_ = server_.audience_.join(*this, address_);
        if (ticket) server_.audience_.admit(*seat_, *ticket);
        const std::string early = std::exchange(head_, {});
        take_messages({reinterpret_cast<const std::uint8_t*>(early.data()), early.size()});
        if (!ended_) read_messages();
      }));
}

void WebServer::Connection::read_messages() {
  stream_->read(safely([this](const std::error_code& error, std::span<const std::uint8_t> bytes) {
    if (error) return end();
    take_messages(bytes);
    if (!ended_) read_messages();
  }));
}

void WebServer::Connection::take_messages(std::span<const std::uint8_t> bytes) {
  if (!socket_->receive(bytes)) return end();
  pump();
}

/// Its time to show a token is over; from here on only writing has a limit.
void WebServer::Connection::admitted() {
  stays_ = true;
  deadline_.cancel();
  server_.show();
}

void WebServer::Connection::send(const std::string& text) {
  socket_->send_text(text);
  pump();
}

void WebServer::Connection::send(const Bytes& binary) {
  socket_->send_binary(binary);
  pump();
}

bool WebServer::Connection::ready() const { return !writing_ && !socket_->has_output(); }

void WebServer::Connection::close(WebSocketClose code, std::string_view reason) {
  seat_.reset();  // the audience has taken it away
  closing_ = true;
  socket_->close(code, reason);
  set_deadline(kCloseTime);
  pump();
}

/// Writes what the WebSocket has to say, one piece after the other.
void WebServer::Connection::pump() {
  if (writing_ || ended_) return;
  if (!socket_->has_output()) {
    if (socket_->closed()) end();
    return;
  }
  std::vector<std::uint8_t> output = socket_->take_output();
  if (output.empty()) return;
  writing_ = true;
  if (stays_ && !closing_) set_deadline(kWriteTime);
  stream_->write(std::move(output), safely([this](const std::error_code& error) {
                   writing_ = false;
                   if (error) return end();
                   if (stays_ && !closing_) deadline_.cancel();
                   pump();
                 }));
}

/// The answer to a request; then the connection ends. Closing over unread bytes would reset it, and
/// the answer would be lost: so it is read until the other end closes too, or the deadline ends it.
void WebServer::Connection::write_last(std::vector<std::uint8_t> bytes) {
  stream_->write(std::move(bytes), safely([this](const std::error_code& error) {
                   if (error) return end();
                   stream_->end_writing();
                   discard();
                 }));
}

void WebServer::Connection::discard() {
  stream_->read(safely([this](const std::error_code& error, std::span<const std::uint8_t>) {
    if (error) return end();
    discard();
  }));
}

}  // namespace feltwire::web
