#pragma once
// The UDP port of a scene: datagrams in, answers out.

#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <asio/ip/udp.hpp>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/time_counts.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

struct DatagramPortOptions {
  asio::ip::address address;  // to listen on
  std::uint16_t port = 0;     // 0: the operating system chooses
  int socket = -1;            // already bound, and owned by the exchange from now on; -1: none
  int dscp = 0;               // of the replies (protocol/net/udp_socket.hpp)
};

/// Takes datagrams in batches, lets the sessions answer, and accounts the time. Owns the socket and
/// the buffers of one batch. Only the scene's thread calls it. It allocates nothing of its own
/// after its construction.
class DatagramExchange {
 public:
  /// Binds the port. Throws std::runtime_error in one line when it cannot. All references outlive
  /// this. `clock`: the monotonic clock of the scene. `posts`: requests of other threads that wait
  /// for the scene's thread; they wait for at most one answer.
  DatagramExchange(asio::io_context& io, const DatagramPortOptions& options,
                   SceneSessions& sessions, const std::function<Nanoseconds()>& clock,
                   const std::atomic<int>& posts);
  ~DatagramExchange();

  /// To wait for datagrams: it does not block.
  asio::ip::udp::socket& socket() { return socket_; }
  std::uint16_t port() const { return port_; }
  /// Whether datagrams were taken from the socket that have no answer yet.
  bool has_datagrams() const noexcept;

  /// Answers the rest of a batch in one go; takes a new batch if nothing is left. Stops early if
  /// there are posts, or if answers are slow and the time is `until` (set here if it is empty).
  /// Returns the number of datagrams that it answered; 0: none had come.
  std::size_t exchange(std::optional<Nanoseconds>& until);
  /// Whether another exchange may follow at once: the batch was full, nothing is posted, and it is
  /// earlier than `until`. Precondition: exchange() has just returned `taken`.
  bool may_go_on(std::size_t taken, const std::optional<Nanoseconds>& until) const noexcept;
  /// The time of the answers to the newest exchange.
  Nanoseconds served_at() const noexcept { return served_at_; }

  /// Sends goodbyes, to those whose address is known.
  void say(const std::vector<GoodbyeDatagram>& goodbyes) noexcept;

  /// Totals: datagrams that the operating system did not accept; and times of the answers, each
  /// from the begin of its exchange.
  std::uint64_t unsent() const noexcept { return unsent_; }
  const TimeCounts& answer_times() const noexcept { return answers_; }

 private:
  struct Batch;
  bool receive();
  Nanoseconds tick_apart(Nanoseconds now);
  Nanoseconds account(Nanoseconds since);
  void send(std::size_t count) noexcept;
  void learn_path(std::size_t sent) noexcept;
  bool posts_wait() const noexcept { return posts_.load(std::memory_order_relaxed) > 0; }

  SceneSessions& sessions_;
  const std::function<Nanoseconds()>& clock_;
  const std::atomic<int>& posts_;
  asio::ip::udp::socket socket_;
  std::unique_ptr<Batch> batch_;
  bool slow_ = false;              // answers take so long that the clock is read for each
  Nanoseconds served_at_{0};       // time of the answers to the newest exchange
  Nanoseconds measured_until_{0};  // no path is measured again before
  std::uint64_t unsent_ = 0;
  TimeCounts answers_;
  std::uint16_t port_ = 0;
};

}  // namespace feltwire
