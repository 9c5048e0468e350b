#include "server/web/connection.hpp"

#include <spdlog/spdlog.h>

#include <asio/post.hpp>
#include <utility>

namespace feltwire::web {
namespace {

constexpr std::chrono::seconds kWriteTime{10};  // longest time of a write to a viewer
constexpr std::chrono::seconds kPieceTime{60};  // longest time of a piece of a file to a client
constexpr std::chrono::seconds kCloseTime{2};   // longest wait for the answer to a close

}  // namespace

Connection::Connection(ConnectionHost& host, ConnectionSlots::Id id, std::unique_ptr<Stream> stream,
                       const asio::ip::address& address)
    : host_(host), id_(id), address_(address), stream_(std::move(stream)), deadline_(host.io()) {}

/// Returns a handler that calls `work` and keeps this connection alive. The handler does nothing
/// after end(). If `work` throws, only this connection ends.
template <class Work>
auto Connection::safely(Work work) {
  return [self = shared_from_this(), work = std::move(work)](const auto&... results) {
    if (self->ended_) return;
    try {
      work(results...);
    } catch (const std::exception& error) {
      spdlog::error("{}: a connection from {} ends, the server failed at it: {}",
                    self->host_.log_name(), self->address_.to_string(), error.what());
      self->end();
    }
  };
}

void Connection::set_deadline(std::chrono::milliseconds patience) {
  deadline_.expires_after(patience);
  deadline_.async_wait(safely([this](const std::error_code& cancelled) {
    if (!cancelled) end();
  }));
}

void Connection::end() noexcept {
  if (ended_) return;
  ended_ = true;
  stream_->close();
  deadline_.cancel();
  if (seat_) host_.hub().leave(*seat_);
  host_.ended(id_);
}

void Connection::start() {
  set_deadline(host_.patience());
  stream_->handshake(safely([this](const std::error_code& error) {
    if (error) return end();
    read_head();
  }));
}

void Connection::read_head() {
  stream_->read(safely([this](const std::error_code& error, std::span<const std::uint8_t> bytes) {
    if (error) return end();
    head_.append(bytes.begin(), bytes.end());
    if (const auto length = http_head_length(head_)) return answer_head(*length);
    if (head_.size() <= kMaxHttpHead) return read_head();
    write_last(http_response(nullptr, {}));
  }));
}

void Connection::answer_head(std::size_t length) {
  const auto request = parse_http_head(std::string_view(head_).substr(0, length));
  HttpResponse answered = http_response(request ? &*request : nullptr, host_.site(address_));
  if (!answered.upgraded) return write_last(std::move(answered));
  head_.erase(0, length);
  become_viewer(std::move(answered));
}

void Connection::become_viewer(HttpResponse accepted) {
  const auto take = [this](std::string_view message) {
    if (seat_) host_.hub().receive(*seat_, message);
  };
  const auto begun = [this] {
    if (seat_) host_.hub().count(*seat_);
  };
  socket_ = std::make_unique<WebSocket>(ViewerHub::kMostMessage, take, begun);
  writing_ = true;
  stream_->write(
      {std::move(accepted.bytes), {}},
      safely([this, ticket = accepted.ticket](const std::error_code& error) {
        writing_ = false;
        if (error) return end();
        seat_ = host_.hub().join(*this, address_);
        if (ticket) host_.hub().admit(*seat_, *ticket);
        const std::string early = std::exchange(head_, {});
        take_messages({reinterpret_cast<const std::uint8_t*>(early.data()), early.size()});
      }));
}

/// Reads the next bytes, but only if no output waits. So for a viewer that does not read, the
/// server stores at most the answers to one read.
void Connection::read_on() {
  if (reading_ || taking_ || writing_ || ended_ || socket_->has_output()) return;
  reading_ = true;
  stream_->read(safely([this](const std::error_code& error, std::span<const std::uint8_t> bytes) {
    reading_ = false;
    if (error || (closing_ && !discards(bytes.size()))) return end();
    take_messages(bytes);
  }));
}

void Connection::take_messages(std::span<const std::uint8_t> bytes) {
  taking_ = true;
  const bool good = socket_->receive(bytes);
  taking_ = false;
  if (!good) return end();
  if (!socket_->reads()) part();
  pump();
}

/// Ignores further messages of the viewer, and gives it kCloseTime to answer the close.
void Connection::part() {
  if (closing_ || ended_) return;
  closing_ = true;
  if (seat_) host_.hub().leave(*std::exchange(seat_, std::nullopt));
  host_.parting(id_);
  set_deadline(kCloseTime);
}

/// Stops the deadline for the token, because the viewer has shown a valid one. From now on, only
/// writes have a time limit.
void Connection::admitted() {
  stays_ = true;
  deadline_.cancel();
  host_.admitted(id_);
}

void Connection::send(const std::string& text) {
  if (overfull_) return;
  socket_->send_text(text);
  pump();
  if (socket_->waiting() <= kMostWaiting) return;
  // Call end() later, because the hub may be iterating over its viewers now.
  overfull_ = true;
  asio::post(host_.io(), safely([this] { end(); }));
}

void Connection::show_text(const SharedBytes& text) {
  socket_->send_text(text);
  pump();
}

void Connection::show_binary(std::span<const std::uint8_t> head, const SharedBytes& data) {
  socket_->send_binary(data, head);
  pump();
}

void Connection::ping() {
  if (overfull_) return;
  socket_->ping();
  pump();
}

bool Connection::ready() const {
  return !writing_ && !closing_ && !overfull_ && !socket_->has_output();
}

void Connection::close(WebSocketClose code, std::string_view reason) {
  seat_.reset();  // the hub has already removed the viewer
  socket_->close(code, reason);
  part();
  pump();
}

/// Writes the output of the WebSocket, one part after another. Then reads the next bytes.
void Connection::pump() {
  if (writing_ || ended_) return;
  Output output = socket_->take_output();
  if (output.empty()) {
    if (socket_->closed()) return end();
    return read_on();
  }
  writing_ = true;
  if (stays_ && !closing_) set_deadline(kWriteTime);
  stream_->write(std::move(output), safely([this](const std::error_code& error) {
                   writing_ = false;
                   if (error) return end();
                   if (stays_ && !closing_) deadline_.cancel();
                   pump();
                 }));
}

/// Writes the last answer. Then reads and discards until the other end closes, until it has sent
/// more than kMostDiscarded, or until the deadline. Closing a socket with unread bytes would reset
/// the connection, and the answer would be lost.
void Connection::write_last(HttpResponse last) {
  // A connection with a ticket for a file is no stranger any more.
  if (last.file != nullptr) host_.admitted(id_);
  stream_->write({std::move(last.bytes), last.body},
                 safely([this, file = std::move(last.file)](const std::error_code& error) {
                   if (error) return end();
                   if (file != nullptr) return write_file(file);
                   stream_->end_writing();
                   discard();
                 }));
}

/// Writes the rest of the file, one piece after another: the next one is read when the last one is
/// written. So a slow client costs the memory of one piece.
void Connection::write_file(const std::shared_ptr<SentFile>& file) {
  std::vector<std::uint8_t> piece = file->next();
  if (piece.empty()) {
    set_deadline(kCloseTime);
    host_.parting(id_);
    stream_->end_writing();
    return discard();
  }
  set_deadline(kPieceTime);
  stream_->write({std::move(piece), {}}, safely([this, file](const std::error_code& error) {
                   if (error) return end();
                   write_file(file);
                 }));
}

void Connection::discard() {
  stream_->read(safely([this](const std::error_code& error, std::span<const std::uint8_t> bytes) {
    if (error || !discards(bytes.size())) return end();
    discard();
  }));
}

/// Counts the discarded bytes. Returns false if there were more than kMostDiscarded.
bool Connection::discards(std::size_t count) {
  discarded_ += count;
  return discarded_ <= kMostDiscarded;
}

}  // namespace feltwire::web
