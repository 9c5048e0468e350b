#include "server/scene/scene_sessions.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/build_info/build_info.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/session/lead_share.hpp"

namespace feltwire {
namespace {

constexpr unsigned kReceived =
    set_of({DatagramKind::samples, DatagramKind::goodbye, DatagramKind::follower_state});

void add(SceneCounters& sum, const Session& session) {
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

void add(WorldCounters& sum, const WorldCounters& more) {
  sum.steps += more.steps;
  sum.resets += more.resets;
  sum.returned += more.returned;
  sum.warnings += more.warnings;
}

/// Tells whether the client must correct the device or the parameters.
control::RefusalCode refusal_code(const control::JoinRequest& request) {
  try {
    validate(request.device);
  } catch (const std::invalid_argument&) {
    return control::RefusalCode::bad_device;
  }
  return control::RefusalCode::bad_parameters;
}

std::string no_such_tool(const Scene& scene, const std::string& asked) {
  const std::string what = "there is no tool '" + asked + "' in scene '" + scene.name() + "'; ";
  if (scene.tool().name.empty()) return what + "all hands hold the same there: ask for none";
  return what + "the existing ones are: " + scene.tool_names();
}

}  // namespace

control::Refused unknown_session(std::uint64_t id) {
  return {control::RefusalCode::unknown_session,
          "there is no session " + std::to_string(id) + " here; it may have ended by silence"};
}

/// Why a session ends without a request, and the counter for it.
struct SceneSessions::Ending {
  GoodbyeReason reason;
  std::uint64_t SceneCounters::*counter;
  SessionEnd how;
};

SceneSessions::SceneSessions(const Scene& scene, Nanoseconds silence_timeout,
                             std::size_t max_sessions, const NetworkProfile* line,
                             const SessionLimits& limits)
    : scene_(&scene),
      silence_timeout_(silence_timeout),
      max_sessions_(max_sessions),
      line_(line),
      limits_(limits),
      by_id_(max_sessions),
      share_(max_sessions) {
  slots_.reserve(max_sessions);
  hands_.reserve(max_sessions);
  ended_.reserve(max_sessions);
  std::unique_ptr<World> world = world_of(scene);
  std::vector<Seat> seats = seats_of(scene, world.get());
  take_over(scene, std::move(world), std::move(seats));
}

/// Null if nothing moves in the scene.
std::unique_ptr<World> SceneSessions::world_of(const Scene& scene) const {
  return scene.mechanism() == nullptr ? nullptr : std::make_unique<World>(scene);
}

void SceneSessions::take_over(const Scene& scene, std::unique_ptr<World> world,
                              std::vector<Seat> seats) noexcept {
  scene_ = &scene;
  world_ = std::move(world);
  if (world_ != nullptr) tick_ = from_seconds(world_->tick());
  seats_ = std::move(seats);
}

std::vector<SceneSessions::GoodbyeDatagram> SceneSessions::enter(const Scene& scene,
                                                                 Nanoseconds now) {
  // Everything that may throw comes first, before any change.
  std::unique_ptr<World> world = world_of(scene);
  std::vector<Seat> seats = seats_of(scene, world.get());
  const bool same_seats = has_same_seats(scene);
  std::vector<Session::Place> places(slots_.size());
  std::vector<GoodbyeDatagram> goodbyes;
  for (std::size_t i = slots_.size(); i-- > 0;)
    if (const ToolView* view = scene.view(slots_[i]->tool);
        view == nullptr || (!same_seats && (slots_[i]->leads || slots_[i]->role == Role::follower)))
      goodbyes.push_back(goodbye(*slots_[i], GoodbyeReason::evicted));
    else
      places[i] = Session::Place(*view, world.get(), slots_[i]->session.limits());
  log_.announce(scene.files());

  if (world_ != nullptr) add(counters_.world, world_->counters());
  const std::unique_ptr<World> before = std::move(world_);  // kept until no session uses it
  take_over(scene, std::move(world), std::move(seats));
  last_tick_ = now;
  ++version_;
  log_.put({.kind = EventKind::reload, .time = now});
  for (std::size_t i = slots_.size(); i-- > 0;)
    if (places[i].view != nullptr) {
      slots_[i]->session.enter(std::move(places[i]));
      if (!same_seats) slots_[i]->seat = 0;  // it leads no robot
    } else {
      ++counters_.evicted;
      end(*slots_[i], SessionEnd::tool_gone);
    }
  return goodbyes;
}

SceneSessions::~SceneSessions() = default;

control::Message SceneSessions::answer(const control::Message& request, std::uint64_t id,
                                       const SessionKeys& keys, Nanoseconds now) {
  if (const auto* wanted = std::get_if<control::JoinRequest>(&request))
    return join(*wanted, id, keys, now);

  if (const auto* wanted = std::get_if<control::LeaveRequest>(&request)) {
    SessionSlot** slot = by_id_.find(wanted->session);
    if (slot == nullptr) return unknown_session(wanted->session);
    ++counters_.left;
    end(**slot, SessionEnd::asked);
    return control::Left{wanted->session};
  }
  if (const auto* wanted = std::get_if<control::SetParameters>(&request)) {
    auto outcome = change(ParameterChange{wanted->session, wanted->parameters}, now);
    if (auto* refused = std::get_if<control::Refused>(&outcome)) return std::move(*refused);
    return control::ParametersSet{wanted->session, find(wanted->session)->parameters()};
  }
  if (const auto* wanted = std::get_if<control::TakeSurfaces>(&request))
    return take_surfaces(*wanted, now);
  if (std::holds_alternative<control::DescribeScene>(request)) {
    control::SceneDescription described;
    described.times.world_late = counters_.world_late;
    return described;
  }
  if (const auto* wanted = std::get_if<control::DescribeSessions>(&request))
    return describe_after(wanted->after, now);
  if (std::holds_alternative<control::GetCounters>(request)) return named_counters();
  return control::Refused{control::RefusalCode::malformed,
                          "a scene answers join, leave, set parameters, take surfaces, and lists "
                          "of its sessions and counters only"};
}

/// Throws std::invalid_argument if they are not possible.
SessionParameters SceneSessions::granted(const SessionParameters& asked) const {
  if (line_ == nullptr) return asked;
  validate(asked);
  return feltwire::granted(*line_, asked);
}

control::Message SceneSessions::join(control::JoinRequest request, std::uint64_t id,
                                     const SessionKeys& keys, Nanoseconds now) {
  if (slots_.size() >= max_sessions_)
    return control::Refused{control::RefusalCode::full,
                            "scene '" + scene_->name() + "' has all its " +
                                std::to_string(max_sessions_) + " sessions; try again later"};
  const ToolView* view = scene_->view(request.tool);
  if (view == nullptr)
    return control::Refused{control::RefusalCode::unknown_tool,
                            no_such_tool(*scene_, request.tool)};
  if (auto refused = refuse_robot(request)) return *std::move(refused);
  if (const auto wrong = wrong_lead_share(request.lead_share))
    return control::Refused{control::RefusalCode::bad_parameters, "lead_share: " + *wrong};
  // Make the text first: once the session exists nothing may throw.
  control::JoinAccepted accepted;
  accepted.tool = view->tool().name;
  accepted.lists_surfaces = true;
  for (const RemoteSeat& seat : scene_->seats()) accepted.seats.push_back(seat.name);
  accepted.version = version();
  std::vector<std::uint8_t> logged;
  try {
    request.parameters = granted(request.parameters);
    logged = log_.payload(request);
    auto slot = std::make_unique<SessionSlot>(
        SessionSlot{id,
                    Session(request, *view, world_.get()),
                    now,
                    Opener(keys.suite, keys.up, 0, limits_.forgeries),
                    Sealer(keys.suite, keys.down),
                    SampleRate(request.parameters.servo_period, limits_.sample_rate),
                    {},
                    {},
                    request.tool,
                    request.role});
    if (!slot->session.observes()) slot->takes = request.takes;
    slot->lead_share = request.lead_share;
    slot->joined = now;
    if (!by_id_.insert(id, slot.get()))
      return control::Refused{control::RefusalCode::full, "no session id is free; try again"};
    if (slots_.empty()) last_tick_ = now;
    const SessionParameters& parameters = request.parameters;
    slot->share = share_.add(parameters.packet_interval * parameters.servo_period);
    slots_.push_back(std::move(slot));
  } catch (const std::invalid_argument& error) {
    return control::Refused{refusal_code(request), error.what()};
  }
  ++counters_.sessions_served;
  SessionSlot& slot = *slots_.back();
  slot.number = static_cast<std::uint32_t>(counters_.sessions_served);
  slot.figures = request.figures && slot.session.observes();
  if (!slot.session.observes()) hands_.push_back({slot.number, &slot.session});
  if (request.role == Role::follower) {
    const RemoteSeat& wanted = *seat_named(request.seat);
    slot.seat = static_cast<std::uint8_t>(&wanted - scene_->seats().data());
    Seat& seat = seats_[slot.seat];
    seat.robot = &slot;
    seat.own = request.workspace;
    seat.link.seat_robot(slot.number, seat.own);
    accepted.workspace = wanted.workspace;
  }
  log_.put({.kind = EventKind::join, .hand = slot.number, .time = now, .payload = logged});
  accepted.session = id;
  accepted.parameters = request.parameters;
  accepted.silence_timeout = std::chrono::duration<double>(silence_timeout_).count();
  accepted.friction = view->requirements().friction;
  accepted.rotation = view->requirements().rotation;
  accepted.start_position = scene_->start().position;
  accepted.start_normal = scene_->start().normal;
  accepted.stiffness = view->requirements().stiffness;
  return accepted;
}

Bytes SceneSessions::drop(DropReason reason) noexcept {
  ++counters_.drops[static_cast<std::size_t>(reason)];
  return {};
}

/// A client sends its goodbye more than once, because one may be lost: a repeated goodbye is no
/// fault.
Bytes SceneSessions::miss(const Header& header) noexcept {
  if (header.kind != DatagramKind::goodbye ||
      std::find(gone_.begin(), gone_.end(), header.session) == gone_.end())
    return drop(DropReason::session);
  ++counters_.late_goodbyes;
  return {};
}

// The checks follow the order of PROTOCOL.md.
Bytes SceneSessions::receive(Bytes datagram, const Peer& from, Nanoseconds now,
                             DatagramBuffer& out) noexcept {
  ++counters_.datagrams;
  share_.take_up();
  if (world_ != nullptr) tick(now);
  const Guarded guarded = guard(datagram, kReceived);
  if (guarded.drop != DropReason::none) return drop(guarded.drop);

  SessionSlot** found = by_id_.find(guarded.header.session);
  if (found == nullptr) return miss(guarded.header);
  SessionSlot& slot = **found;
  const Opened opened = slot.opener.open(guarded.header, datagram, opened_);
  if (opened.drop == DropReason::packet_number) slot.session.count_duplicate();
  if (opened.drop != DropReason::none) return drop(opened.drop);
  share_.attribute_to(slot.share);
  const bool says_goodbye = guarded.header.kind == DatagramKind::goodbye;
  const bool says_state = guarded.header.kind == DatagramKind::follower_state;
  if (!says_goodbye && says_state != (slot.role == Role::follower)) return drop(DropReason::kind);
  if (!says_goodbye) {
    if (!slot.rate.admit(now)) return drop(DropReason::rate);
    if (!share_.admit(slot.share)) [[unlikely]] {
      ++counters_.shed;
      return drop(DropReason::rate);
    }
    const bool newest = guarded.header.packet_number == slot.opener.highest();
    if (!says_state) return receive_samples(slot, opened.payload, {from, newest, now}, out);
    receive_state(slot, opened.payload, {from, newest, now});
    return {};
  }

  GoodbyeReason reason;
  if (const DropReason wrong = decode(opened.payload, reason); wrong != DropReason::none)
    return drop(wrong);
  ++counters_.left;
  end(slot, SessionEnd::goodbye);
  return {};
}

void SceneSessions::end(SessionSlot& slot, SessionEnd how) noexcept {
  log_.put_end(slot.number, how);
  add(counters_, slot.session);
  // Nobody may ask for them. Then forget them before they take more memory.
  if (ended_.size() == ended_.capacity()) ended_.clear();
  ended_.push_back({slot.id, how});
  by_id_.erase(slot.id);
  if (slot.seat < seats_.size()) {
    Seat& seat = seats_[slot.seat];
    seat.link.leave(slot.number);
    if (seat.robot == &slot) seat.robot = nullptr;
  }
  share_.remove(slot.share);
  gone_[next_gone_++ % gone_.size()] = slot.id;
  std::erase_if(hands_, [&](const ActingHand& hand) { return hand.session == &slot.session; });
  std::erase_if(slots_, [&](const auto& other) { return other.get() == &slot; });
}

SceneSessions::GoodbyeDatagram SceneSessions::goodbye(SessionSlot& slot, GoodbyeReason reason) {
  DatagramBuffer out;
  const Bytes bytes =
      slot.sealer.seal(DatagramKind::goodbye, slot.id, encoder_.goodbye(reason), out);
  return {slot.peer, {bytes.begin(), bytes.end()}};
}

std::optional<SceneSessions::Ending> SceneSessions::ending(const SessionSlot& slot,
                                                           Nanoseconds now) const noexcept {
  if (slot.rate.flooding())
    return Ending{GoodbyeReason::flooding, &SceneCounters::flooded, SessionEnd::flooded};
  if (slot.disturbing)
    return Ending{GoodbyeReason::disturbing, &SceneCounters::disturbing, SessionEnd::disturbing};
  if (slot.opener.exhausted())
    return Ending{GoodbyeReason::evicted, &SceneCounters::forged, SessionEnd::forged};
  if (now - slot.last_heard >= silence_timeout_)
    return Ending{GoodbyeReason::evicted, &SceneCounters::silent, SessionEnd::silent};
  return std::nullopt;
}

std::vector<SceneSessions::GoodbyeDatagram> SceneSessions::expire(Nanoseconds now) {
  std::vector<GoodbyeDatagram> goodbyes;
  for (std::size_t i = 0; i < slots_.size();) {
    SessionSlot& slot = *slots_[i];
    const std::optional<Ending> why = ending(slot, now);
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

std::vector<SceneSessions::GoodbyeDatagram> SceneSessions::evict(std::uint64_t id) {
  SessionSlot** slot = by_id_.find(id);
  if (slot == nullptr) return {};
  return {take_away(**slot, SessionEnd::evicted)};
}

/// Ends a session, and tells its client.
SceneSessions::GoodbyeDatagram SceneSessions::take_away(SessionSlot& slot, SessionEnd how) {
  GoodbyeDatagram datagram = goodbye(slot, GoodbyeReason::evicted);
  ++counters_.evicted;
  end(slot, how);
  return datagram;
}

std::vector<SceneSessions::GoodbyeDatagram> SceneSessions::end_all(GoodbyeReason reason) noexcept {
  std::vector<GoodbyeDatagram> goodbyes;
  while (!slots_.empty()) {
    SessionSlot& slot = *slots_.front();
    try {
      goodbyes.push_back(goodbye(slot, reason));
    } catch (const std::exception&) {
      // The client gets no goodbye, and notices the silence.
    }
    if (reason == GoodbyeReason::failed) ++counters_.failed;
    end(slot, reason == GoodbyeReason::failed ? SessionEnd::failed : SessionEnd::shut_down);
  }
  return goodbyes;
}

SceneCounters SceneSessions::counters() const {
  SceneCounters sum = counters_;
  for (const auto& slot : slots_) add(sum, slot->session);
  if (world_ != nullptr) add(sum.world, world_->counters());
  return sum;
}

void SceneSessions::replay_end(std::uint64_t id, SessionEnd how) noexcept {
  if (SessionSlot** slot = by_id_.find(id)) end(**slot, how);
}

const Session* SceneSessions::find(std::uint64_t id) {
  SessionSlot** slot = by_id_.find(id);
  return slot == nullptr ? nullptr : &(*slot)->session;
}

}  // namespace feltwire
