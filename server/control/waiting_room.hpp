#pragma once
// Connections between their arrival and TLS: they wait for their turn.

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "server/access/connection_slots.hpp"
#include "server/access/connection_turns.hpp"

namespace feltwire {

/// Owns the sockets of the waiting connections, their turns and the timer that looks at them. A
/// connection waits without an answer: an answer would need a handshake, which is limited. It is on
/// one thread, that of `io`.
class WaitingRoom {
 public:
  using Id = ConnectionSlots::Id;
  /// Takes over a connection whose turn it is. judge() must then be called once for its address,
  /// also if this throws.
  using Admit =
      std::function<void(Id id, asio::ip::tcp::socket socket, const asio::ip::address& address)>;

  /// `io` outlives this.
  WaitingRoom(asio::io_context& io, const TurnLimits& limits, Admit admit);
  WaitingRoom(const WaitingRoom&) = delete;
  WaitingRoom& operator=(const WaitingRoom&) = delete;

  /// A connection has come. Admits at once the connections whose turn it is. Throws what `admit`
  /// throws, and std::bad_alloc.
  void arrive(asio::ip::tcp::socket socket);
  /// Starts the timer again after an exception of its handler; does nothing if it runs, or if
  /// nobody waits.
  void keep_looking();
  /// The fate of a connection that was admitted (ConnectionTurns::judge).
  void judge(const asio::ip::address& address, ConnectionTurns::Outcome outcome);
  /// Closes the waiting connections and stops the timer.
  void close();

  /// The number of connections that were closed because their turn did not come.
  std::uint64_t sent_away() const { return sent_away_; }

 private:
  void admit_due();
  void admit(Id id);
  void send_away(std::optional<Id> id);

  struct Waiting {
    asio::ip::tcp::socket socket;
    asio::ip::address address;
  };
  Admit admit_;
  std::map<Id, Waiting> waiting_;
  ConnectionTurns turns_;
  asio::steady_timer next_look_;
  bool looking_ = false;  // the timer runs
  Id next_id_ = 0;
  std::uint64_t sent_away_ = 0;
};

}  // namespace feltwire
