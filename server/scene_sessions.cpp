#include "server/scene_sessions.hpp"

#include <algorithm>
#include <stdexcept>

#include "protocol/guard.hpp"

namespace feltwire {
namespace {

constexpr unsigned bit(DatagramKind kind) { return 1u << static_cast<unsigned>(kind); }
constexpr unsigned kReceived = bit(DatagramKind::samples) | bit(DatagramKind::goodbye);

control::Refused unknown_session(std::uint64_t id) {
  return {control::RefusalCode::unknown_session,
          "there is no session " + std::to_string(id) + " here; it may have ended by silence"};
}

void add(SceneCounters& sum, const Session& session) {
  const SessionCounters& counters = session.counters();
  sum.samples.samples += counters.samples;
  sum.samples.replies += counters.replies;
  sum.samples.withheld += counters.withheld;
  sum.samples.gaps += counters.gaps;
  sum.samples.missed += counters.missed;
  sum.samples.duplicates += counters.duplicates;
  sum.violations += session.violations();
}

/// Which of the two a client must mend.
control::RefusalCode refusal_code(const control::JoinRequest& request) {
  try {
    validate(request.device);
  } catch (const std::invalid_argument&) {
    return control::RefusalCode::bad_device;
  }
  return control::RefusalCode::bad_parameters;
}

}  // namespace

/// A session and what belongs to its transport.
struct SceneSessions::Seat {
  std::uint64_t id;
  Session session;
  Nanoseconds last_heard;
  PacketWindow received;
  Peer peer;                       // of the newest sample
  std::uint64_t packets_sent = 0;  // numbers of what goes to the client
};

SceneSessions::SceneSessions(const Scene& scene, Nanoseconds silence_timeout,
                             std::size_t max_sessions, const NetworkProfile* line)
    : scene_(scene),
      silence_timeout_(silence_timeout),
      max_sessions_(max_sessions),
      line_(line),
      by_id_(max_sessions) {
  seats_.reserve(max_sessions);
}

SceneSessions::~SceneSessions() = default;

control::Message SceneSessions::answer(const control::Message& request, std::uint64_t id,
                                       Nanoseconds now) {
  if (const auto* wanted = std::get_if<control::JoinRequest>(&request))
    return join(*wanted, id, now);

  if (const auto* wanted = std::get_if<control::LeaveRequest>(&request)) {
    Seat** seat = by_id_.find(wanted->session);
    if (seat == nullptr) return unknown_session(wanted->session);
    ++counters_.left;
    end(**seat);
    return control::Left{wanted->session};
  }
  if (const auto* wanted = std::get_if<control::SetParameters>(&request)) {
    Seat** seat = by_id_.find(wanted->session);
    if (seat == nullptr) return unknown_session(wanted->session);
    try {
      (*seat)->session.set_parameters(granted(wanted->parameters));
    } catch (const std::invalid_argument& error) {
      return control::Refused{control::RefusalCode::bad_parameters, error.what()};
    }
    return control::ParametersSet{wanted->session, (*seat)->session.parameters()};
  }
  return control::Refused{control::RefusalCode::malformed,
                          "a scene answers join, leave and set parameters only"};
}

/// Throws std::invalid_argument when they are not possible.
SessionParameters SceneSessions::granted(const SessionParameters& asked) const {
  if (line_ == nullptr) return asked;
  validate(asked);
  return feltwire::granted(*line_, asked);
}

control::Message SceneSessions::join(control::JoinRequest request, std::uint64_t id,
                                     Nanoseconds now) {
  if (seats_.size() >= max_sessions_)
    return control::Refused{control::RefusalCode::full,
                            "scene '" + scene_.name() + "' has all its " +
                                std::to_string(max_sessions_) + " sessions; try again later"};
  try {
    request.parameters = granted(request.parameters);
    auto seat = std::make_unique<Seat>(Seat{id, Session(request, scene_), now, {}, {}});
    if (!by_id_.insert(id, seat.get()))
      return control::Refused{control::RefusalCode::full, "no session id is free; try again"};
    seats_.push_back(std::move(seat));
  } catch (const std::invalid_argument& error) {
    return control::Refused{refusal_code(request), error.what()};
  }
  ++counters_.sessions_served;
  control::JoinAccepted accepted;
  accepted.session = id;
  accepted.parameters = request.parameters;
  accepted.silence_timeout = std::chrono::duration<double>(silence_timeout_).count();
  accepted.friction = scene_.requirements().friction;
  accepted.rotation = scene_.requirements().rotation;
  accepted.start_position = scene_.start().position;
  accepted.start_normal = scene_.start().normal;
  accepted.stiffness = scene_.requirements().stiffness;
  return accepted;
}

Bytes SceneSessions::drop(DropReason reason) noexcept {
  ++counters_.drops[static_cast<std::size_t>(reason)];
  return {};
}

// The checks stand in the order of PROTOCOL.md.
Bytes SceneSessions::receive(Bytes datagram, const Peer& from, Nanoseconds now) noexcept {
  ++counters_.datagrams;
  const Guarded guarded = guard(datagram, kReceived);
  if (guarded.drop != DropReason::none) return drop(guarded.drop);

  Seat** found = by_id_.find(guarded.header.session);
  if (found == nullptr) return drop(DropReason::session);
  Seat& seat = **found;
  if (!seat.received.take(guarded.header.packet_number)) {
    seat.session.count_duplicate();
    return drop(DropReason::packet_number);
  }
  if (guarded.header.kind == DatagramKind::samples)
    return receive_samples(seat, guarded.payload, from, now);

  GoodbyeReason reason;
  if (const DropReason wrong = decode(guarded.payload, reason); wrong != DropReason::none)
    return drop(wrong);
  ++counters_.left;
  end(seat);
  return {};
}

Bytes SceneSessions::receive_samples(Seat& seat, Bytes payload, const Peer& from,
                                     Nanoseconds now) noexcept {
  if (const DropReason wrong = decode(payload, batch_); wrong != DropReason::none)
    return drop(wrong);
  const Taken taken = seat.session.take(batch_, now);
  if (taken.drop != DropReason::none) return drop(taken.drop);
  seat.last_heard = now;
  seat.peer = from;
  if (taken.withheld) return {};
  return encoder_.reply(seat.id, ++seat.packets_sent, taken.reply);
}

void SceneSessions::end(Seat& seat) noexcept {
  add(counters_, seat.session);
  by_id_.erase(seat.id);
  std::erase_if(seats_, [&](const auto& other) { return other.get() == &seat; });
}

SceneSessions::Farewell SceneSessions::farewell(Seat& seat, GoodbyeReason reason) {
  const Bytes bytes = encoder_.goodbye(seat.id, ++seat.packets_sent, reason);
  return {seat.peer, {bytes.begin(), bytes.end()}};
}

std::vector<SceneSessions::Farewell> SceneSessions::expire(Nanoseconds now) {
  std::vector<Farewell> farewells;
  for (std::size_t i = 0; i < seats_.size();) {
    Seat& seat = *seats_[i];
    if (now - seat.last_heard < silence_timeout_) {
      ++i;
      continue;
    }
    farewells.push_back(farewell(seat, GoodbyeReason::evicted));
    ++counters_.silent;
    end(seat);
  }
  return farewells;
}

std::vector<SceneSessions::Farewell> SceneSessions::shut_down() {
  std::vector<Farewell> farewells;
  while (!seats_.empty()) {
    farewells.push_back(farewell(*seats_.front(), GoodbyeReason::shutting_down));
    end(*seats_.front());
  }
  return farewells;
}

SceneCounters SceneSessions::counters() const {
  SceneCounters sum = counters_;
  for (const auto& seat : seats_) add(sum, seat->session);
  return sum;
}

const Session* SceneSessions::find(std::uint64_t id) {
  Seat** seat = by_id_.find(id);
  return seat == nullptr ? nullptr : &(*seat)->session;
}

}  // namespace feltwire
