#include "server/scene/datagram_exchange.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "protocol/net/datagram_io.hpp"
#include "protocol/net/listen_error.hpp"
#include "protocol/net/udp_socket.hpp"
#include "protocol/wire/guard.hpp"
#include "server/scene/datagram_batch.hpp"

namespace feltwire {
namespace {

// Longest time for which answers to datagrams delay the timers. Posted handlers wait only for the
// present answer.
constexpr std::chrono::milliseconds kTurn{2};
// [ns] If the mean time of an answer is above this, the clock is read at each answer. A reading
// takes 20 to 50 ns if it needs no system call, which is less than a thousandth of such an answer.
constexpr Nanoseconds kSlowAnswer{100'000};
// Network paths that are known to be too small for a reply are measured once in this time.
constexpr std::chrono::milliseconds kBetweenMeasures{10};
// [bytes] Size of the receive buffer: it has room for a burst of about 5000 samples.
constexpr int kSocketBuffer = 1 << 20;

}  // namespace

DatagramExchange::DatagramExchange(asio::io_context& io, const DatagramPortOptions& options,
                                   SceneSessions& sessions,
                                   const std::function<Nanoseconds()>& clock,
                                   const std::atomic<int>& posts)
    : sessions_(sessions),
      clock_(clock),
      posts_(posts),
      socket_(io),
      batch_(std::make_unique<Batch>()) {
  const asio::ip::udp::endpoint endpoint(options.address, options.port);
  try {
    if (options.socket >= 0) {
      socket_.assign(endpoint.protocol(), options.socket);
    } else {
      socket_.open(endpoint.protocol());
      serve_both_families(socket_, options.address);
      socket_.bind(endpoint);
    }
    const int descriptor = socket_.native_handle();
    if (!forbid_fragments(descriptor) || (options.dscp != 0 && !set_dscp(descriptor, options.dscp)))
      throw std::system_error(errno, std::generic_category());
    if (options.address.is_unspecified() && !report_local_address(descriptor))
      throw std::system_error(errno, std::generic_category());
    socket_.set_option(asio::socket_base::receive_buffer_size(kSocketBuffer));
    socket_.non_blocking(true);
    port_ = socket_.local_endpoint().port();
  } catch (const std::system_error& error) {
    throw listen_error("udp", options.address, options.port, error.code());
  }
}

DatagramExchange::~DatagramExchange() = default;

bool DatagramExchange::has_datagrams() const noexcept { return batch_->next < batch_->count; }

bool DatagramExchange::may_go_on(std::size_t taken,
                                 const std::optional<Nanoseconds>& until) const noexcept {
  return taken == Batch::kMost && !posts_wait() && served_at_ < *until;
}

/// Receives a batch of datagrams. Returns false if none has come.
bool DatagramExchange::receive() {
  Batch& batch = *batch_;
  batch.rearm(batch.count);
  batch.next = batch.count = 0;
  const int count = ::recvmmsg(socket_.native_handle(), batch.incoming.data(), Batch::kMost,
                               MSG_DONTWAIT, nullptr);
  if (count <= 0) return false;
  batch.count = static_cast<std::size_t>(count);
  return true;
}

std::size_t DatagramExchange::exchange(std::optional<Nanoseconds>& until) {
  if (!has_datagrams() && !receive()) return 0;
  Batch& batch = *batch_;
  const Nanoseconds begin = clock_();
  if (!until) until = begin + kTurn;
  const std::size_t first = batch.next;
  std::size_t answers = 0;
  Nanoseconds now = tick_apart(begin);
  const Nanoseconds answering = now;
  do {
    const std::size_t i = batch.next++;
    Peer& peer = batch.peers[i];
    peer.length = batch.incoming[i].msg_hdr.msg_namelen;
    peer.local = local_address(batch.incoming[i].msg_hdr);
    const Bytes datagram{batch.received[i].data(), batch.incoming[i].msg_len};
    if (slow_) now = tick_apart(now);
    const Bytes answer = sessions_.receive(datagram, peer, now, batch.sent[answers]);
    if (!answer.empty()) batch.put(answers++, answer.size(), peer);
    if (slow_) now = account(now);
  } while (has_datagrams() && !posts_wait() && !(slow_ && now >= *until));
  // Send only the newest target to each robot, because older targets are useless.
  for (std::size_t seat = 0; seat < sessions_.seats(); ++seat)
    if (const Bytes target = sessions_.forward(seat, now, batch.robots[seat], batch.sent[answers]);
        !target.empty())
      batch.put(answers++, target.size(), batch.robots[seat]);
  const std::size_t taken = batch.next - first;
  served_at_ = slow_ ? now : account(answering);
  answers_.record((served_at_ - begin).count(), taken);
  slow_ = served_at_ - answering > static_cast<Nanoseconds::rep>(taken) * kSlowAnswer;
  send(answers);
  return taken;
}

/// Steps the moving bodies if a step is due, and charges the computing time to no session. Returns
/// the time after the step.
Nanoseconds DatagramExchange::tick_apart(Nanoseconds now) {
  const auto due = sessions_.next_tick();
  if (!due || *due > now) return now;
  sessions_.tick(now);
  const Nanoseconds after = clock_();
  sessions_.spent_otherwise(after - now);
  return after;
}

/// Charges the time from `since` to now to the sessions that sent the datagrams. Returns the
/// present time.
Nanoseconds DatagramExchange::account(Nanoseconds since) {
  const Nanoseconds now = clock_();
  sessions_.spent(now - since, now);
  return now;
}

/// Measures the largest packet size of a network path after a reply was too long for it. Limits the
/// later replies of the session to this size.
void DatagramExchange::learn_path(std::size_t sent) noexcept {
  const std::size_t size = batch_->sent_parts[sent].iov_len;
  const Guarded guarded = guard({batch_->sent[sent].bytes.data(), size},
                                set_of({DatagramKind::reply, DatagramKind::follower_target}));
  if (guarded.drop != DropReason::none || guarded.header.kind != DatagramKind::reply) return;
  const std::uint64_t session = guarded.header.session;
  // If the path is known to be too small for this reply, do not measure it each time.
  if (sessions_.is_limited(session, size - kOverhead) && served_at_ < measured_until_) return;
  measured_until_ = served_at_ + kBetweenMeasures;
  const msghdr& message = batch_->outgoing[sent].msg_hdr;
  const auto& to = *static_cast<const sockaddr_storage*>(message.msg_name);
  std::size_t longest = size - kOverhead - 1;
  if (const auto mtu = path_mtu(to, message.msg_namelen); mtu && *mtu > 0) {
    const auto packet = static_cast<std::size_t>(*mtu);
    longest = std::min(longest, packet - std::min(packet, header_bytes(to) + kOverhead));
  }
  sessions_.limit_replies(session, longest, served_at_);
}

void DatagramExchange::send(std::size_t count) noexcept {
  for (std::size_t done = 0; done < count;) {
    const int sent = ::sendmmsg(socket_.native_handle(), batch_->outgoing.data() + done,
                                static_cast<unsigned>(count - done), MSG_DONTWAIT);
    if (sent > 0) {
      done += static_cast<std::size_t>(sent);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS) {
      // The send buffer is full, so these replies are lost. The next replies are newer anyway.
      unsent_ += count - done;
      return;
    } else if (errno == EMSGSIZE) {
      learn_path(done);
      ++unsent_;  // this reply is lost; later replies are short enough
      ++done;
    } else if (errno != EINTR) {
      ++unsent_;  // this reply cannot be sent, for example without a route; others can
      ++done;
    }
  }
}

void DatagramExchange::say(const std::vector<GoodbyeDatagram>& goodbyes) noexcept {
  for (const auto& goodbye : goodbyes) {
    if (goodbye.to.length == 0) continue;  // the client sent no sample, so its address is unknown
    if (!send_datagram(socket_.native_handle(), goodbye.datagram,
                       reinterpret_cast<const sockaddr*>(&goodbye.to.address), goodbye.to.length,
                       goodbye.to.local))
      ++unsent_;
  }
}

}  // namespace feltwire
