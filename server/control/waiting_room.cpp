#include "server/control/waiting_room.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <new>
#include <system_error>
#include <utility>

#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

using asio::ip::tcp;
constexpr std::chrono::milliseconds kBetweenLooks{10};

/// Returns whether the client has closed the connection while it waited.
bool has_left(tcp::socket& socket) {
  char next = 0;
  const ssize_t size = ::recv(socket.native_handle(), &next, sizeof next, MSG_PEEK | MSG_DONTWAIT);
  return size == 0 || (size < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

}  // namespace

WaitingRoom::WaitingRoom(asio::io_context& io, const TurnLimits& limits, Admit admit)
    : admit_(std::move(admit)), turns_(limits), next_look_(io) {}

void WaitingRoom::arrive(tcp::socket socket) {
  std::error_code gone;
  const asio::ip::address address = socket.remote_endpoint(gone).address();
  if (gone) return;
  const Id id = next_id_++;
  waiting_.emplace(id, Waiting{std::move(socket), address});
  try {
    send_away(turns_.arrive(id, address, monotonic_now()));
  } catch (const std::bad_alloc&) {
    waiting_.erase(id);
    throw;
  }
  admit_due();
}

/// Admits the waiting connections whose turn it is, and closes those that have waited too long.
void WaitingRoom::admit_due() {
  keep_looking();  // start the timer first, because the rest may throw
  const Nanoseconds now = monotonic_now();
  while (const auto id = turns_.admit(now)) admit(*id);
  while (const auto id = turns_.give_up(now)) send_away(id);
}

void WaitingRoom::keep_looking() {
  if (looking_ || waiting_.empty()) return;
  next_look_.expires_after(kBetweenLooks);
  next_look_.async_wait([this](const std::error_code& cancelled) {
    looking_ = false;
    if (!cancelled) admit_due();
  });
  looking_ = true;
}

void WaitingRoom::admit(Id id) {
  auto waited = waiting_.extract(id);
  if (waited.empty()) return;
  auto& [socket, address] = waited.mapped();
  if (has_left(socket)) return judge(address, ConnectionTurns::Outcome::left);
  admit_(id, std::move(socket), address);
}

void WaitingRoom::send_away(std::optional<Id> id) {
  if (id && waiting_.erase(*id) > 0) ++sent_away_;
}

void WaitingRoom::judge(const asio::ip::address& address, ConnectionTurns::Outcome outcome) {
  turns_.judge(address, outcome, monotonic_now());
}

void WaitingRoom::close() {
  next_look_.cancel();
  waiting_.clear();
}

}  // namespace feltwire
