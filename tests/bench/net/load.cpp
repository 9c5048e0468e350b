#include "tests/bench/net/load.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numbers>

#include "client/transport/datagram_session.hpp"
#include "core/base/splitmix.hpp"
#include "protocol/wire/guard.hpp"
#include "server/scene/id_map.hpp"
#include "tests/bench/net/flood.hpp"

namespace feltwire::netbench {
namespace {

constexpr std::size_t kAtOnce = 64;
constexpr Nanoseconds kLate = std::chrono::milliseconds(1);
// After this time a saturating client sends again.
constexpr Nanoseconds kLost = std::chrono::milliseconds(20);
// number of samples since the newest sample with an answer
constexpr std::uint64_t kLeftBehind = 100;
constexpr unsigned kAnyKind = ~0u;

/// Moves on a circle at 0.3 m/s over the room's table and through the objects on it. The height
/// varies from 0.5 mm above the top to 2 mm below.
class Path {
 public:
  Path() {
    for (std::size_t i = 0; i < kSteps; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / kSteps;
      points_[i] = {kRadius * std::cos(angle), kRadius * std::sin(angle),
                    kMiddle + kDip * std::sin(kDips * angle)};
    }
  }
  const Vec3& at(std::uint64_t step) const { return points_[step % kSteps]; }

 private:
  static constexpr std::size_t kSteps = 1024;
  static constexpr double kRadius = 0.05, kMiddle = -0.05075, kDip = 0.00125;  // [m]
  static constexpr double kDips = 5.0;
  std::array<Vec3, kSteps> points_;
};

struct Client {
  DatagramSession datagrams;
  Opener echoes;  // opens the client's own returned samples
  Sample sample;
  std::uint64_t phase = 0;     // position along the path
  std::uint64_t answered = 0;  // newest sample with an answer
};

/// The contents of an answer or of a returned sample.
struct Answer {
  std::uint64_t index = 0;
  Nanoseconds sent{0};
  Command command;
};

}  // namespace

struct Load::Clients {
  LoadOptions options;
  bool echoed;
  Socket socket;
  Path path;
  std::deque<Client> all;
  IdMap<std::uint32_t> places;
  Reply reply;
  SampleBatch batch;
  DatagramBuffer opened;
  LoadResult result;
  std::unique_ptr<Flood> flood;
  bool counting = false;
  Nanoseconds counted_from{0};

  std::array<std::array<std::uint8_t, kMaxDatagram>, kAtOnce> out{}, in{};
  std::array<iovec, kAtOnce> out_parts{}, in_parts{};
  std::array<mmsghdr, kAtOnce> outgoing{}, incoming{};
  std::size_t queued = 0;

  Clients(const Target& target, bool echo, const LoadOptions& wanted)
      : options(wanted), echoed(echo), places(target.sessions.size()) {
    socket.connect(target.port);
    if (options.sleep) socket.set_patience(kLost);
    if (options.flood) flood = std::make_unique<Flood>(target.port, options.known_sessions);
    const SessionParameters parameters = join_request(options.redundancy).parameters;
    for (std::size_t i = 0; i < target.sessions.size(); ++i) {
      const SessionKeys keys = session_keys(target.sessions[i], options.suite);
      all.push_back({DatagramSession(target.sessions[i], keys, parameters, false),
                     Opener(keys.suite, keys.up),
                     {},
                     splitmix::draw(7, i),
                     0});
      places.insert(target.sessions[i], static_cast<std::uint32_t>(i));
    }
    for (std::size_t i = 0; i < kAtOnce; ++i) {
      out_parts[i] = {out[i].data(), 0};
      in_parts[i] = {in[i].data(), kMaxDatagram};
      outgoing[i].msg_hdr.msg_iov = &out_parts[i];
      incoming[i].msg_hdr.msg_iov = &in_parts[i];
      outgoing[i].msg_hdr.msg_iovlen = incoming[i].msg_hdr.msg_iovlen = 1;
    }
  }

  void queue(Client& client) {
    Sample& sample = client.sample;
    ++sample.index;
    sample.client_time = now();
    sample.pose.position = path.at(client.phase + sample.index);
    const Bytes bytes = client.datagrams.pack(sample);
    std::copy(bytes.begin(), bytes.end(), out[queued].begin());
    out_parts[queued].iov_len = bytes.size();
    result.sample_size = bytes.size();
    if (counting) ++result.sent;
    if (++queued == kAtOnce) flush();
  }

  void flush() {
    for (std::size_t done = 0; done < queued;) {
      const int sent = ::sendmmsg(socket.file(), outgoing.data() + done,
                                  static_cast<unsigned>(queued - done), 0);
      if (sent <= 0) break;  // The sample counts as never answered.
      done += static_cast<std::size_t>(sent);
    }
    queued = 0;
  }

  /// Takes the datagrams that arrived, and calls `then` for each client with an answer.
  template <class Then>
  bool receive(int flags, Then then) {
    const int count = ::recvmmsg(socket.file(), incoming.data(), kAtOnce, flags, nullptr);
    if (count <= 0) return false;
    const Nanoseconds arrival = now();
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      Client* client = take({in[i].data(), incoming[i].msg_len}, arrival);
      if (client != nullptr) then(*client);
    }
    return true;
  }

  Client* take(Bytes bytes, Nanoseconds arrival) {
    const Guarded guarded = guard(bytes, kAnyKind);
    std::uint32_t* place =
        guarded.drop == DropReason::none ? places.find(guarded.header.session) : nullptr;
    Answer answer;
    if (place == nullptr || !read(all[*place], guarded.header, bytes, answer)) {
      ++result.bad;
      return nullptr;
    }
    Client& client = all[*place];
    client.answered = std::max(client.answered, answer.index);
    client.sample.held = answer.command;
    if (!counting) return &client;
    const Nanoseconds took = arrival - answer.sent;
    ++result.answered;
    LoadResult::Window& window = window_at(arrival);
    ++window.answered;
    if (took > kLate) {
      ++result.late;
      ++window.late;
    }
    result.round_trip.record(took.count());
    result.answer_size = bytes.size();
    if (answer.command.elastic.squaredNorm() > 0.0) ++result.with_force;
    return &client;
  }

  LoadResult::Window& window_at(Nanoseconds time) {
    const auto place = static_cast<std::size_t>((time - counted_from) / LoadResult::kWindow);
    return result.windows[std::min(place, result.windows.size() - 1)];
  }

  bool read(Client& client, const Header& header, Bytes bytes, Answer& answer) {
    if (echoed) {
      const Opened echo = client.echoes.open(header, bytes, opened);
      if (echo.drop != DropReason::none || decode(echo.payload, batch) != DropReason::none)
        return false;
      answer = {batch.samples[0].index, batch.samples[0].client_time, {}};
    } else {
      GoodbyeReason ignored;
      if (client.datagrams.take(bytes, reply, ignored) != DatagramSession::Arrival::reply)
        return false;
      answer = {reply.sample_index, reply.client_time, reply.command};
    }
    return true;
  }

  /// Each client sends once per period at its own phase. Equal periods keep the order of the
  /// clients.
  void pace(Nanoseconds until, Nanoseconds start, std::uint64_t& turn) {
    const auto count = static_cast<std::uint64_t>(all.size());
    const auto due = [&](std::uint64_t t) {
      const auto phase = static_cast<std::int64_t>(t % count) * options.period.count() /
                         static_cast<std::int64_t>(count);
      return start + static_cast<std::int64_t>(t / count) * options.period + Nanoseconds(phase);
    };
    Nanoseconds before = now();
    for (Nanoseconds time = before; time < until; before = time, time = now()) {
      if (counting) result.longest_pause = std::max(result.longest_pause, time - before);
      for (std::size_t i = 0; i < kAtOnce && due(turn) <= time; ++i) queue(all[turn++ % count]);
      flush();
      receive(MSG_DONTWAIT, [](const Client&) {});
      if (flood) flood->burst();
    }
  }

  /// Every client always waits for an answer.
  void saturate(Nanoseconds until) {
    Nanoseconds heard = now() - kLost;
    for (Nanoseconds time = heard + kLost; time < until; time = now()) {
      const int flags = options.sleep ? MSG_WAITFORONE : MSG_DONTWAIT;
      if (receive(flags, [this](Client& client) {
            // An echo may return an older sample. The client must wait for its newest.
            if (client.answered == client.sample.index) queue(client);
          })) {
        heard = time;
      } else if (time - heard >= kLost) {
        // At the start, or after losses, every waiting client sends again.
        for (Client& client : all) queue(client);
        heard = time;
      }
      flush();
    }
  }

  void drain() {
    const Nanoseconds end = now() + kLost;
    while (now() < end) receive(MSG_DONTWAIT, [](const Client&) {});
  }
};

double LoadResult::late_share_between_stalls() const {
  std::vector<double> shares;
  for (const Window& window : windows)
    shares.push_back(window.answered > 0
                         ? static_cast<double>(window.late) / static_cast<double>(window.answered)
                         : 1.0);
  if (shares.empty()) return 1.0;
  std::nth_element(shares.begin(), shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2),
                   shares.end());
  return shares[shares.size() / 2];
}

Load::Load(const Target& target, bool echoed, const LoadOptions& options)
    : clients_(std::make_unique<Clients>(target, echoed, options)) {}
Load::~Load() = default;

LoadResult Load::run(pid_t host) {
  Clients& c = *clients_;
  const LoadOptions& options = c.options;
  const Nanoseconds start = now();
  std::uint64_t turn = 0;
  const auto play = [&](Nanoseconds until) {
    if (options.saturate)
      c.saturate(until);
    else
      c.pace(until, start, turn);
  };
  play(start + options.warm_up);
  c.counting = true;
  const Nanoseconds cpu = cpu_time(host), begin = now();
  c.counted_from = begin;
  const std::uint64_t garbage = c.flood ? c.flood->sent() : 0;
  c.result.windows.resize(static_cast<std::size_t>(options.duration / LoadResult::kWindow) + 1);
  play(begin + options.duration);
  c.result.wall = now() - begin;
  c.result.server_cpu = cpu_time(host) - cpu;
  if (!options.saturate) c.drain();
  if (c.flood) c.result.garbage = c.flood->sent() - garbage;
  c.result.left_behind =
      static_cast<int>(std::count_if(c.all.begin(), c.all.end(), [](const Client& client) {
        return client.answered + kLeftBehind < client.sample.index;
      }));
  return c.result;
}

}  // namespace feltwire::netbench
