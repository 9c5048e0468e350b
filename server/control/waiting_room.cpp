// Connections between their arrival and TLS: they wait for their turn
// (server/access/connection_turns.hpp).

#include <chrono>
#include <new>
#include <utility>

#include "protocol/net/clock.hpp"
#include "server/control/control_endpoint.hpp"

namespace feltwire {
namespace {

using asio::ip::tcp;
using Error = std::error_code;
constexpr std::chrono::milliseconds kBetweenLooks{10};

}  // namespace

/// The connection waits without an answer: an answer would need a handshake, which is limited.
void ControlEndpoint::greet(tcp::socket socket) {
  Error gone;
  const asio::ip::address address = socket.remote_endpoint(gone).address();
  if (gone) return;
  const ConnectionSlots::Id id = next_id_++;
  waiting_.emplace(id, Waiting{std::move(socket), address});
  try {
    send_away(turns_.arrive(id, address, monotonic_now()));
  } catch (const std::bad_alloc&) {
    waiting_.erase(id);
    throw;
  }
  let_in();
}

/// Lets in the connections whose turn it is, and sends away those that waited too long.
void ControlEndpoint::let_in() {
  if (!waiting_.empty()) look_again();  // first, because the rest may throw
  const Nanoseconds now = monotonic_now();
  while (const auto id = turns_.admit(now)) open(*id);
  while (const auto id = turns_.give_up(now)) send_away(id);
}

void ControlEndpoint::look_again() {
  if (looking_) return;
  next_look_.expires_after(kBetweenLooks);
  next_look_.async_wait([this](const Error& cancelled) {
    looking_ = false;
    if (!cancelled) let_in();
  });
  looking_ = true;
}

void ControlEndpoint::send_away(std::optional<ConnectionSlots::Id> id) {
  if (id && waiting_.erase(*id) > 0) ++counters_.too_often;
}

}  // namespace feltwire
