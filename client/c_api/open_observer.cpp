#include "client/c_api/open_observer.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <utility>

#include "client/c_api/c_values.hpp"
#include "client/observer/query_thread.hpp"
#include "client/transport/control_dialogue.hpp"
#include "client/transport/listing.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

/// The first and the longest limit of the waits between attempts to join again.
constexpr std::chrono::milliseconds kFirstWait{250}, kLongestWait{4000};
constexpr int kBetweenAsks = 250;  // [ms] between two requests for names
constexpr int kLongestLook = 16;   // [ms] between two looks for views
constexpr double kNotTold = std::numeric_limits<double>::quiet_NaN();

fw_seen_hand to_c(const SeenHand& seen, double time) {
  fw_seen_hand hand{};
  hand.struct_size = sizeof hand;
  hand.number = seen.number;
  hand.time = time;
  put(seen.pose, hand.position, hand.orientation);
  put(seen.force, hand.force);
  hand.balance = hand.round_trip = kNotTold;
  if (!seen.figures) {
    put(seen.pose.position, hand.proxy);
    return hand;
  }
  const HandFigures& figures = *seen.figures;
  hand.states = figures.states;
  put(figures.elastic + figures.frictional, hand.commanded);
  put(figures.proxy, hand.proxy);
  hand.depth = figures.depth;
  hand.delivered = figures.delivered;
  hand.burned = figures.burned;
  hand.samples = figures.samples;
  hand.missed = figures.missed;
  hand.tool = figures.tool;
  if (!figures.report) return hand;
  if (figures.report->has_account) hand.balance = figures.report->balance;
  if (figures.report->round_trip > 0.0) hand.round_trip = figures.report->round_trip;
  return hand;
}

fw_seen_body to_c(const SeenBody& seen, double time) {
  fw_seen_body body{};
  body.struct_size = sizeof body;
  body.object = seen.object;
  body.time = time;
  put(seen.pose, body.position, body.orientation);
  return body;
}

}  // namespace

OpenObserver::OpenObserver(ServerAccess server, ObserverRequest request, double patience)
    : route_(std::move(server)),
      request_(std::move(request)),
      patience_(patience),
      opened_(monotonic_now().count()),
      session_(std::make_unique<ObserverSession>(route_, request_)),
      thread_([this] { run(); }) {}

OpenObserver::~OpenObserver() { end(); }

bool OpenObserver::latest(fw_scene_state& state) const noexcept {
  State newest{};
  if (latest_.get(newest) == 0) return false;
  state = newest.state;
  state.age = 1e-9 * static_cast<double>(monotonic_now().count() - newest.clock);
  return true;
}

std::optional<std::string> OpenObserver::name_of(std::uint32_t hand) const {
  const std::lock_guard lock(shared_.mutex);
  const auto found = shared_.names.find(hand);
  return found != shared_.names.end() ? std::optional(found->second) : std::nullopt;
}

OpenObserver::News OpenObserver::wait(std::uint64_t number, double timeout) const {
  constexpr double kLongest = 1e6;  // [s]
  const auto until = std::chrono::steady_clock::now() +
                     std::chrono::duration_cast<std::chrono::nanoseconds>(
                         std::chrono::duration<double>(std::min(timeout, kLongest)));
  std::unique_lock lock(shared_.mutex);
  shared_.changed.wait_until(lock, until, [&] { return shared_.ended || shared_.number > number; });
  return shared_.number > number ? News::newer : shared_.ended ? News::ended : News::none;
}

std::string OpenObserver::error() const {
  const std::lock_guard lock(shared_.mutex);
  return shared_.error;
}

std::string OpenObserver::end() noexcept {
  stop_.set();
  if (thread_.joinable()) thread_.join();
  try {
    return error();
  } catch (const std::exception&) {  // no memory for the text
    return {};
  }
}

/// Observes until it is told to stop, or a lost session is not found again.
void OpenObserver::run() {
  std::string why;
  try {
    const QueryThread asking([this](const Event& over) { ask_names(over); });
    while (session_ != nullptr) {
      why = observe(*session_);
      session_.reset();
      if (stop_.is_set()) break;
      seen_ = {};
      publish(false);
      if (patience_ > 0.0) messages_.keep(why + "; the scene is looked for again");
      session_ = find_again(why);
      if (session_ != nullptr) messages_.keep("the scene is observed again");
    }
  } catch (const std::exception& error) {
    why = error.what();
  }
  session_.reset();
  const std::lock_guard lock(shared_.mutex);
  if (!stop_.is_set()) shared_.error = std::move(why);
  shared_.ended = true;
  shared_.changed.notify_all();
}

/// Takes the views of a session until it ends. Returns the reason for the end.
std::string OpenObserver::observe(ObserverSession& session) {
  const double began = 1e-9 * static_cast<double>(monotonic_now().count() - opened_);
  const int look =
      std::clamp(static_cast<int>(std::lround(1e3 * request_.period)), 1, kLongestLook);
  std::array<pollfd, 2> waiting{
      {{stop_.descriptor(), POLLIN, 0}, {session.over_descriptor(), POLLIN, 0}}};
  TimedView shown;
  while (!stop_.is_set() && !session.over()) {
    bool news = false;
    while (session.take(shown)) {
      take(shown, began);
      news = true;
    }
    if (news) publish(true);
    ::poll(waiting.data(), waiting.size(), look);
  }
  return session.end();
}

/// Joins again after the session was lost. Returns nothing, and the reason in `why`, if the
/// patience is over, the server refuses for good, or the observer is closed.
std::unique_ptr<ObserverSession> OpenObserver::find_again(std::string& why) {
  const std::int64_t until = monotonic_now().count() + from_seconds(patience_).count();
  Backoff backoff(kFirstWait, kLongestWait, random_seed());
  while (monotonic_now().count() < until) {
    wait_for(stop_, static_cast<int>(backoff.next().count()));
    if (stop_.is_set()) return nullptr;
    try {
      return std::make_unique<ObserverSession>(route_, request_);
    } catch (const LastingError& error) {
      why = error.what();
      return nullptr;
    } catch (const SessionError&) {  // try again
    }
  }
  return nullptr;
}

/// `began` [s]: the start of the session, since the observer was opened.
void OpenObserver::take(const TimedView& shown, double began) {
  seen_.take(shown.view);
  const double time = began + shown.time;
  newest_.state.time = time;
  newest_.clock = monotonic_now().count();
  for (const std::uint32_t gone : seen_.hands_gone()) times_.hands.erase(gone);
  for (const std::uint16_t gone : seen_.bodies_gone()) times_.bodies.erase(gone);
  for (const SeenHand& hand : shown.view.hands()) {
    if (!seen_.hands().contains(hand.number)) continue;  // it had no room
    const auto [at, is_new] = times_.hands.insert_or_assign(hand.number, time);
    if (is_new) has_newcomers_.store(true);
  }
  for (const SeenBody& body : shown.view.bodies())
    if (seen_.bodies().contains(body.object)) times_.bodies.insert_or_assign(body.object, time);
}

/// Gives the state to all readers.
void OpenObserver::publish(bool connected) {
  if (!connected) {
    times_.hands.clear();
    times_.bodies.clear();
  }
  told_hands_.clear();
  for (const auto& [number, hand] : seen_.hands())
    told_hands_.push_back(to_c(hand, times_.hands[number]));
  told_bodies_.clear();
  for (const auto& [object, body] : seen_.bodies())
    told_bodies_.push_back(to_c(body, times_.bodies[object]));
  hands_.put(told_hands_);
  bodies_.put(told_bodies_);
  fw_scene_state& state = newest_.state;
  ++state.number;
  state.hands = static_cast<std::uint32_t>(told_hands_.size());
  state.bodies = static_cast<std::uint32_t>(told_bodies_.size());
  state.connected = connected ? 1 : 0;
  state.left_out = static_cast<std::uint32_t>(seen_.left_out());
  latest_.put(newest_);
  const std::lock_guard lock(shared_.mutex);
  shared_.number = state.number;
  shared_.changed.notify_all();
}

/// Asks for the names of hands while there are new ones, until `over` is set.
void OpenObserver::ask_names(const Event& over) {
  while (!over.is_set()) {
    if (has_newcomers_.exchange(false) && !ask_once()) has_newcomers_.store(true);
    wait_for(over, kBetweenAsks);
  }
}

/// Returns whether the server has answered, or will never.
bool OpenObserver::ask_once() {
  try {
    ControlDialogue server(route_.host(), request_.timeout);
    ListRoom room(kRoomOfServer);
    std::map<std::uint32_t, std::string> names;
    for (auto& session : described_sessions(server, request_.scene, room))
      names.emplace(session.number, std::move(session.client));
    const std::lock_guard lock(shared_.mutex);
    shared_.names = std::move(names);
    return true;
  } catch (const LastingError&) {
    return true;  // a server that is too old does not know the request
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace feltwire
