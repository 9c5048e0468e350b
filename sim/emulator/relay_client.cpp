#include "sim/emulator/relay_client.hpp"

#include <asio/buffer.hpp>

namespace feltwire {
namespace {

using Error = std::error_code;

}  // namespace

RelayClient::RelayClient(const asio::any_io_executor& executor,
                         const asio::ip::udp::endpoint& scene, std::unique_ptr<TwoWayLink> link,
                         SendBack send_back)
    : server_(executor, scene.protocol()),
      timer_(executor),
      link_(std::move(link)),
      send_back_(std::move(send_back)) {
  server_.connect(scene);
  server_.non_blocking(true);
}

void RelayClient::enter(Bytes datagram, Nanoseconds now) {
  last_heard_ = now;
  link_->up.enter(datagram, now);
  pump();
}

void RelayClient::await_server() {
  server_.async_wait(
      asio::ip::udp::socket::wait_read, [self = shared_from_this()](const Error& stopped) {
        if (stopped) return;
        const Nanoseconds now = relay_now();
        for (int i = 0; i < kBurst; ++i) {
          Error error;
          const std::size_t size = self->server_.receive(asio::buffer(self->buffer_), 0, error);
          if (error == asio::error::would_block) break;
          // Ignore an error. It means that the server did not receive an earlier datagram.
          if (!error) self->link_->down.enter({self->buffer_.data(), size}, now);
        }
        self->pump();
        self->await_server();
      });
}

/// Sends the datagrams that are due, and sets the timer for the next datagram.
void RelayClient::pump() {
  const Nanoseconds now = relay_now();
  while (const auto datagram = link_->up.leave(now)) {
    Error error;
    server_.send(asio::buffer(datagram->data(), datagram->size()), 0, error);
    if (error) ++unsent_;
  }
  while (const auto datagram = link_->down.leave(now))
    if (!send_back_(*datagram)) ++unsent_;

  const auto due = link_->next_due();
  if (due == armed_) return;
  armed_ = due;
  if (!due) return;
  timer_.expires_at(asio::steady_timer::time_point(*due));
  timer_.async_wait([self = shared_from_this()](const Error& stopped) {
    if (stopped) return;
    self->armed_.reset();
    self->pump();
  });
}

void RelayClient::close() {
  Error ignored;
  server_.close(ignored);
  timer_.cancel();
}

}  // namespace feltwire
