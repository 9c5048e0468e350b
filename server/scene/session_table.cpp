#include "server/scene/session_table.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/build_info/build_info.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/session/lead_share.hpp"
#include "protocol/session/role.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

void add(SessionTableCounters& sum, const Session& session) {
  const SessionCounters& counters = session.counters();
  sum.samples.samples += counters.samples;
  sum.samples.replies += counters.replies;
  sum.samples.withheld += counters.withheld;
  sum.samples.gaps += counters.gaps;
  sum.samples.missed += counters.missed;
  sum.samples.duplicates += counters.duplicates;
  sum.samples.late_ticks += counters.late_ticks;
  for (std::size_t i = 0; i < HandTimes::kClasses; ++i) {
    sum.client_wakeups[i] += session.times().wakeups()[i];
    sum.client_round_trips[i] += session.times().round_trips()[i];
  }
}

/// Returns `bad_device` if the device of the request is invalid, else `bad_parameters`.
RefusalCode refusal_code(const control::JoinRequest& request) {
  try {
    validate(request.device);
  } catch (const std::invalid_argument&) {
    return RefusalCode::bad_device;
  }
  return RefusalCode::bad_parameters;
}

std::string no_such_tool(const Scene& scene, const std::string& asked) {
  const std::string what = "there is no tool '" + asked + "' in scene '" + scene.name() + "'; ";
  if (scene.tool().name.empty()) return what + "all hands hold the same there: ask for none";
  return what + "the existing ones are: " + scene.tool_names();
}

/// The reason why the server ends a session, and the counter of such ends.
struct Ending {
  GoodbyeReason reason;
  std::uint64_t SessionTableCounters::*counter;
  SessionEnd how;
};

std::optional<Ending> ending(const SessionSlot& slot, Nanoseconds now,
                             Nanoseconds silence_timeout) noexcept {
  using Counters = SessionTableCounters;
  if (slot.rate.flooding())
    return Ending{GoodbyeReason::flooding, &Counters::flooded, SessionEnd::flooded};
  if (slot.blame.disturbing)
    return Ending{GoodbyeReason::disturbing, &Counters::disturbing, SessionEnd::disturbing};
  if (slot.opener.exhausted())
    return Ending{GoodbyeReason::evicted, &Counters::forged, SessionEnd::forged};
  if (now - slot.last_heard >= silence_timeout)
    return Ending{GoodbyeReason::evicted, &Counters::silent, SessionEnd::silent};
  return std::nullopt;
}

}  // namespace

Refused unknown_session(std::uint64_t id) {
  return {RefusalCode::unknown_session,
          "there is no session " + std::to_string(id) + " here; it may have ended by silence"};
}

SessionTable::SessionTable(const TableOptions& options, const ServedScene& served,
                           WorldClock& clock, RobotSeats& seats, FairShare& share, SceneLog& log)
    : options_(options),
      served_(served),
      clock_(clock),
      seats_(seats),
      share_(share),
      log_(log),
      ids_(options.max_sessions) {
  slots_.reserve(options.max_sessions);
  hands_.reserve(options.max_sessions);
  ended_.reserve(options.max_sessions);
}

/// Returns the parameters, with the traffic reduced to the capacity of options_.line. Throws
/// std::invalid_argument if `asked` is invalid.
SessionParameters SessionTable::granted(const SessionParameters& asked) const {
  if (options_.line == nullptr) return asked;
  validate(asked);
  return feltwire::granted(*options_.line, asked);
}

control::Message SessionTable::join(control::JoinRequest request, std::uint64_t id,
                                    const SessionKeys& keys, Nanoseconds now) {
  const Scene& scene = *served_.scene;
  if (slots_.size() >= options_.max_sessions)
    return Refused{RefusalCode::full, "scene '" + scene.name() + "' has all its " +
                                          std::to_string(options_.max_sessions) +
                                          " sessions; try again later"};
  const ToolView* view = scene.view(request.tool);
  if (view == nullptr) return Refused{RefusalCode::unknown_tool, no_such_tool(scene, request.tool)};
  if (auto refused = seats_.refuse(request, scene.name())) return *std::move(refused);
  if (const auto wrong = wrong_lead_share(request.lead_share))
    return Refused{RefusalCode::bad_parameters, "lead_share: " + *wrong};
  // Make the texts of the answer first, because nothing may throw after the session exists.
  control::JoinAccepted accepted;
  accepted.tool = view->tool().name;
  accepted.lists_surfaces = true;
  for (const RemoteSeat& seat : scene.seats()) accepted.seats.push_back(seat.name);
  accepted.version = version();
  std::vector<std::uint8_t> logged;
  try {
    request.parameters = granted(request.parameters);
    logged = log_.payload(request);
    auto slot = std::make_unique<SessionSlot>(id, request, *view, clock_.world(), keys,
                                              options_.session, now);
    if (!ids_.insert(*slot)) return Refused{RefusalCode::full, "no session id is free; try again"};
    if (slots_.empty()) clock_.begin(now);
    const SessionParameters& parameters = request.parameters;
    slot->share = share_.add(parameters.packet_interval * parameters.servo_period);
    slots_.push_back(std::move(slot));
  } catch (const std::invalid_argument& error) {
    return Refused{refusal_code(request), error.what()};
  }
  SessionSlot& slot = *slots_.back();
  slot.number = static_cast<std::uint32_t>(++counters_.sessions_served);
  if (!slot.session.observes()) hands_.push_back({slot.number, &slot.session});
  if (request.role == Role::follower)
    accepted.workspace = seats_.seat_robot(slot, request).workspace;
  log_.put({.kind = EventKind::join, .hand = slot.number, .time = now, .payload = logged});
  accepted.session = id;
  accepted.parameters = request.parameters;
  accepted.silence_timeout = std::chrono::duration<double>(options_.silence_timeout).count();
  accepted.friction = view->requirements().friction;
  accepted.rotation = view->requirements().rotation;
  accepted.start_position = scene.start().position;
  accepted.start_normal = scene.start().normal;
  accepted.stiffness = view->requirements().stiffness;
  return accepted;
}

void SessionTable::leave(SessionSlot& slot, SessionEnd how) noexcept {
  ++counters_.left;
  end(slot, how);
}

void SessionTable::end(SessionSlot& slot, SessionEnd how) noexcept {
  log_.put_end(slot.number, how);
  add(counters_, slot.session);
  // If no one takes the list of ended sessions, clear it, so that push_back() never allocates.
  if (ended_.size() == ended_.capacity()) ended_.clear();
  ended_.push_back({slot.id, how});
  ids_.erase(slot.id);
  seats_.leave(slot);
  share_.remove(slot.share);
  std::erase_if(hands_, [&](const ActingHand& hand) { return hand.session == &slot.session; });
  std::erase_if(slots_, [&](const auto& other) { return other.get() == &slot; });
}

GoodbyeDatagram SessionTable::goodbye(SessionSlot& slot, GoodbyeReason reason) {
  DatagramBuffer out;
  const Bytes bytes =
      slot.sealer.seal(DatagramKind::goodbye, slot.id, encoder_.goodbye(reason), out);
  return {slot.peer, {bytes.begin(), bytes.end()}};
}

std::vector<GoodbyeDatagram> SessionTable::expire(Nanoseconds now) {
  std::vector<GoodbyeDatagram> goodbyes;
  for (std::size_t i = 0; i < slots_.size();) {
    SessionSlot& slot = *slots_[i];
    const std::optional<Ending> why = ending(slot, now, options_.silence_timeout);
    if (!why) {
      ++i;
      continue;
    }
    goodbyes.push_back(goodbye(slot, why->reason));
    ++(counters_.*(why->counter));
    end(slot, why->how);
  }
  return goodbyes;
}

std::vector<GoodbyeDatagram> SessionTable::evict(std::uint64_t id) {
  SessionSlot* const slot = ids_.find(id);
  if (slot == nullptr) return {};
  std::vector<GoodbyeDatagram> goodbyes{goodbye(*slot, GoodbyeReason::evicted)};
  ++counters_.evicted;
  end(*slot, SessionEnd::evicted);
  return goodbyes;
}

std::vector<GoodbyeDatagram> SessionTable::end_all(GoodbyeReason reason) noexcept {
  std::vector<GoodbyeDatagram> goodbyes;
  while (!slots_.empty()) {
    SessionSlot& slot = *slots_.front();
    try {
      goodbyes.push_back(goodbye(slot, reason));
    } catch (const std::exception&) {
      // There is no memory for the goodbye. The client notices that the server is silent.
    }
    if (reason == GoodbyeReason::failed) ++counters_.failed;
    end(slot, reason == GoodbyeReason::failed ? SessionEnd::failed : SessionEnd::shut_down);
  }
  return goodbyes;
}

SessionTable::Moves SessionTable::moves_to(const Scene& scene, World* world, bool same_seats) {
  Moves moves;
  moves.same_seats = same_seats;
  moves.places.resize(slots_.size());
  for (std::size_t i = slots_.size(); i-- > 0;) {
    SessionSlot& slot = *slots_[i];
    const ToolView* const view = scene.view(slot.tool);
    const bool loses_seat = !same_seats && (slot.leads || slot.role == Role::follower);
    if (view == nullptr || loses_seat)
      moves.goodbyes.push_back(goodbye(slot, GoodbyeReason::evicted));
    else
      moves.places[i] = Session::Place(*view, world, slot.session.limits());
  }
  return moves;
}

void SessionTable::carry_out(Moves& moves) noexcept {
  for (std::size_t i = slots_.size(); i-- > 0;)
    if (moves.places[i].view != nullptr) {
      slots_[i]->session.enter(std::move(moves.places[i]));
      if (!moves.same_seats) slots_[i]->seat = 0;  // this session leads no robot
    } else {
      ++counters_.evicted;
      end(*slots_[i], SessionEnd::tool_gone);
    }
}

std::vector<HandDescription> SessionTable::describe() const {
  std::vector<HandDescription> hands;
  for (const auto& slot : slots_)
    if (const Session& session = slot->session; !session.observes())
      hands.push_back({slot->number, slot->id, session.client(), session.device().name, slot->tool,
                       session.parameters(), slot->changes(), session.times(),
                       !seats_.empty() && covers(slot->role, Role::operator_)
                           ? std::optional(slot->lead_share)
                           : std::nullopt,
                       slot->joined});
  return hands;
}

control::SessionDescriptions SessionTable::describe_after(std::uint32_t number,
                                                          Nanoseconds now) const {
  control::SessionDescriptions list;
  for (const auto& slot : slots_) {
    if (slot->number <= number) continue;
    if (list.sessions.size() == control::kMaxDescriptions) {
      list.more = true;
      break;
    }
    const Session& session = slot->session;
    const SessionCounters& counters = session.counters();
    control::SessionDescription entry;
    entry.number = slot->number;
    entry.session = slot->id;
    entry.client = session.client();
    entry.device = session.device().name;
    entry.tool = slot->tool;
    entry.role = slot->role;
    entry.parameters = session.parameters();
    entry.samples = counters.samples;
    entry.missed = counters.missed;
    entry.delivered = session.delivered().total();
    entry.burned = session.burned();
    if (const auto& report = session.report()) {
      if (report->round_trip > 0.0) entry.round_trip = report->round_trip;
      if (report->has_account) entry.balance = report->balance;
      if (report->hand_damping > 0.0) entry.hand_damping = report->hand_damping;
    }
    entry.seconds = std::max(seconds(now - slot->joined), 0.0);
    entry.times = session.times();
    entry.changes = slot->changes();
    entry.lead_share = slot->lead_share;
    if (slot->leads || slot->role == Role::follower) entry.seat = seats_.name(slot->seat);
    list.sessions.push_back(std::move(entry));
  }
  return list;
}

SessionTableCounters SessionTable::counters() const {
  SessionTableCounters sum = counters_;
  for (const auto& slot : slots_) add(sum, slot->session);
  return sum;
}

}  // namespace feltwire
