#include "server/scene/scene_host.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <future>
#include <stdexcept>

#include "protocol/net/clock.hpp"
#include "protocol/net/post.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire {
namespace {

// Number of polls for datagrams between two polls of the timers: about 10 us if no datagram comes.
constexpr unsigned kTurnsBetweenLooks = 32;
// Shortest and longest time between two checks for sessions that must end.
constexpr std::chrono::milliseconds kSoonest{10}, kLatest{100};

/// A request of another thread and its answer. That thread allocates both, so that the scene's
/// thread can answer without allocation if it shuts down or fails.
struct PendingAnswer {
  control::Message request;
  SceneHost::Completion completion;
  control::Message answer = control::Refused{control::RefusalCode::shutting_down,
                                             "the server is shutting down; join another"};
  control::Message failure =
      control::Refused{control::RefusalCode::failed, "the server failed at this; its log says why"};
};

}  // namespace

SceneHost::SceneHost(Scene scene, const SceneHostOptions& options)
    : name_(scene.name()),
      scene_(std::make_shared<const Scene>(std::move(scene))),
      published_(options.events != nullptr),
      options_(options),
      sessions_(*scene_, options.silence_timeout, options.max_sessions, options.line,
                options.limits),
      datagrams_(io_, {options.address, options.port, options.socket, options.dscp}, sessions_,
                 options_.clock, posts_),
      log_(name_) {
  sessions_.log_to(options.events);
  published_.set(scene_, sessions_);
}

SceneHost::~SceneHost() { stop(); }

/// Posts a handler to the scene's thread. `posts_` counts the handlers that wait, so that the
/// thread can interrupt a batch of answers for them.
template <class Handler>
void SceneHost::post(Handler handler) {
  asio::post(io_, [this, handler = std::move(handler)]() mutable {
    posts_.fetch_sub(1, std::memory_order_relaxed);
    handler();
  });
  posts_.fetch_add(1, std::memory_order_relaxed);
}

void SceneHost::start() {
  await_silence();
  thread_ = std::thread([this] { run(); });
}

void SceneHost::stop() {
  if (!thread_.joinable()) return;
  post([this] {
    closing_ = true;  // set first, so that the thread ends even if a call below throws
    datagrams_.say(sessions_.shut_down());
    publish();
  });
  thread_.join();
}

void SceneHost::ask(control::Message request, std::uint64_t id, const SessionKeys& keys,
                    asio::io_context& back, Completion completion) {
  auto pending =
      std::make_shared<PendingAnswer>(PendingAnswer{std::move(request), std::move(completion)});
  post([this, pending = std::move(pending), id, keys, &back] {
    try {
      if (!closing_)
        pending->answer = sessions_.answer(pending->request, id, keys, options_.clock());
      if (auto* named = std::get_if<control::Counters>(&pending->answer))
        named->counters.push_back({"unsent", datagrams_.unsent()});
      if (auto* described = std::get_if<control::SceneDescription>(&pending->answer))
        described->times.answers = datagrams_.answer_times();
    } catch (const std::exception& error) {
      spdlog::error("scene {}: a request was refused, the server failed at it: {}", name_,
                    error.what());
      pending->answer = std::move(pending->failure);
    }
    published_.set_sessions(sessions_.size());
    post_patiently(post_to(back), [pending] { pending->completion(std::move(pending->answer)); });
    await_tick();
    publish();
  });
}

void SceneHost::reload(Scene scene) {
  post([this, next = std::make_shared<const Scene>(std::move(scene))]() mutable {
    if (!closing_) enter(std::move(next));
  });
}

/// Moves all sessions to another scene. If that fails, they stay in the present scene.
void SceneHost::enter(std::shared_ptr<const Scene> next) {
  std::vector<GoodbyeDatagram> goodbyes;
  try {
    goodbyes = sessions_.enter(*next, options_.clock());
  } catch (const std::exception& error) {
    return spdlog::error(
        "scene {}: the server failed to enter the reloaded scene: {}; the scene "
        "stays as it was",
        name_, error.what());
  }
  datagrams_.say(goodbyes);
  if (!goodbyes.empty())
    spdlog::info("scene {}: sessions that ended, for it has their tool no more: {}", name_,
                 goodbyes.size());
  scene_ = std::move(next);
  published_.set(scene_, sessions_);
  publish();  // sessions whose tool is missing in the new scene have ended
  log_.begin_anew();
  await_tick();
}

void SceneHost::change(LiveChange change, PostBack back,
                       std::function<void(std::variant<std::string, control::Refused>)> done) {
  using control::Refused;
  struct Wanted {
    LiveChange change;
    std::function<void(std::variant<std::string, Refused>)> done;
    std::variant<std::string, Refused> outcome = Refused{
        control::RefusalCode::shutting_down, "the server is shutting down; nothing changed"};
    Refused failure{control::RefusalCode::failed,
                    "the server failed at this; its log says why, and nothing changed"};
  };
  auto wanted = std::make_shared<Wanted>(Wanted{std::move(change), std::move(done)});
  post([this, wanted = std::move(wanted), back = std::move(back)] {
    try {
      if (!closing_) wanted->outcome = make(wanted->change);
    } catch (const std::exception& error) {
      spdlog::error("scene {}: a change was refused, the server failed at it: {}", name_,
                    error.what());
      wanted->outcome = std::move(wanted->failure);
    }
    post_patiently(back, [wanted] { wanted->done(std::move(wanted->outcome)); });
  });
}

/// Makes the change. Returns its description, or the reason of the refusal.
std::variant<std::string, control::Refused> SceneHost::make(const LiveChange& change) {
  ChangeOutcome outcome = sessions_.change(change, options_.clock());
  if (auto* refused = std::get_if<control::Refused>(&outcome)) return std::move(*refused);
  auto& made = std::get<Changed>(outcome);
  if (made.scene != nullptr) scene_ = std::move(made.scene);
  if (std::holds_alternative<MaterialChange>(change) ||
      std::holds_alternative<GravityChange>(change))
    published_.set(scene_, sessions_);
  return std::move(made.what);
}

void SceneHost::evict(std::uint64_t session) {
  post([this, session] {
    if (closing_) return;
    datagrams_.say(sessions_.evict(session));
    publish();
  });
}

void SceneHost::describe(PostBack back, std::function<void(std::vector<HandDescription>)> done) {
  post([this, back = std::move(back), done = std::move(done)]() mutable {
    if (closing_) return;
    back([hands = sessions_.describe(), done = std::move(done)]() mutable {
      done(std::move(hands));
    });
  });
}

/// Writes a checksum of the moving bodies to the event log once a second. A replay compares it.
void SceneHost::check(Nanoseconds now) noexcept {
  constexpr std::chrono::seconds kBetween{1};
  if (options_.events == nullptr || now - checked_at_ < kBetween) return;
  checked_at_ = now;
  sessions_.check(now);
}

/// Publishes the number of sessions, logs what has changed, and reports the sessions that ended.
void SceneHost::publish() {
  published_.set_sessions(sessions_.size());
  log_.tell_of_sessions(sessions_);
  if (sessions_.ended().empty()) return;
  if (options_.ended) options_.ended({sessions_.ended().begin(), sessions_.ended().end()});
  sessions_.forget_ended();
}

void SceneHost::ask_for_real_time() {
  const int priority = options_.busy_poll == kForever ? 0 : kScenePriority;
  if (const std::string less = missing(request_real_time(priority), priority); !less.empty())
    spdlog::warn("scene {}: answers may be late now and then: {}", name_, less);
}

/// Runs the loop of the scene's thread until closing_ is set.
void SceneHost::run() {
  if (options_.real_time) ask_for_real_time();
  while (!closing_) {
    try {
      turn();
    } catch (const std::exception& error) {
      recover(error);
    }
  }
}

/// Waits for a datagram, a timer or a posted handler, and handles it. The silence timer is always
/// pending, so Asio always has work and run_one() waits.
void SceneHost::turn() {
  if (!silence_wait_.pending) await_silence();
  await_tick();
  if (options_.busy_poll.count() > 0) spin();
  if (closing_) return;
  if (datagrams_.has_datagrams()) {
    // These datagrams have left the socket, so the socket does not report them again.
    io_.poll();
    if (!closing_) serve();
    return;
  }
  if (!datagram_wait_.pending) await_datagrams();
  io_.run_one();
}

/// Ends all sessions of the scene, because its state is unknown after an exception. The scene then
/// accepts new sessions. Other scenes are not affected.
void SceneHost::recover(const std::exception& failure) noexcept {
  constexpr std::chrono::milliseconds kPause{10};  // prevents a busy loop if the failure repeats
  try {
    log_.tell_of_failure(failure, options_.clock());
    datagrams_.say(sessions_.fail());
    publish();
  } catch (const std::exception&) {
    // The log or publish() failed. A later publish() reports the sessions that ended.
  }
  std::this_thread::sleep_for(kPause);
}

/// Exchanges datagrams until none has come for the time options_.busy_poll. Runs posted handlers
/// and timers between the exchanges.
void SceneHost::spin() {
  Nanoseconds quiet_since = options_.clock();
  for (unsigned turn = 1; !closing_; ++turn) {
    if (turn % kTurnsBetweenLooks == 0 || posts_wait()) io_.poll();
    if (closing_) return;
    if (sessions_.next_tick()) sessions_.tick(options_.clock());
    std::optional<Nanoseconds> until;
    if (exchange(until) > 0) {
      quiet_since = kForever;
    } else if (options_.busy_poll != kForever) {
      const Nanoseconds now = options_.clock();
      quiet_since = std::min(quiet_since, now);
      if (now - quiet_since >= options_.busy_poll) return;
    }
  }
}

/// Exchanges the datagrams that have come, for a limited time. Then it returns, so that other
/// handlers can run. Datagrams that are left in the socket wake the thread again.
void SceneHost::serve() {
  std::optional<Nanoseconds> until;
  while (datagrams_.may_go_on(exchange(until), until)) {
  }
}

/// Exchanges one batch of datagrams, and publishes the result. Returns their number.
std::size_t SceneHost::exchange(std::optional<Nanoseconds>& until) {
  const std::size_t taken = datagrams_.exchange(until);
  if (taken == 0) return 0;
  published_.draw(sessions_, datagrams_.served_at());
  publish();  // a goodbye among the datagrams may have ended a session
  return taken;
}

void SceneHost::await_datagrams() {
  datagrams_.socket().async_wait(asio::ip::udp::socket::wait_read,
                                 in(datagram_wait_.memory, [this](const std::error_code& error) {
                                   datagram_wait_.pending = false;
                                   if (!error) serve();
                                 }));
  datagram_wait_.pending = true;
}

void SceneHost::await_silence() {
  // Check at least every kLatest: a flooding session must end soon, even with a long timeout.
  silence_timer_.expires_after(
      std::clamp<Nanoseconds>(options_.silence_timeout / 4, kSoonest, kLatest));
  silence_timer_.async_wait(in(silence_wait_.memory, [this](const std::error_code& error) {
    silence_wait_.pending = false;
    if (error) return;
    await_silence();
    const Nanoseconds now = options_.clock();
    datagrams_.say(sessions_.expire(now));
    publish();
    log_.tell_of_load(sessions_, now);
    check(now);
    published_.draw(sessions_, now);
  }));
  silence_wait_.pending = true;
}

/// Starts the timer for the next step of the moving bodies, if there is a session. So the bodies
/// move even if no datagram comes.
void SceneHost::await_tick() {
  const auto due = sessions_.next_tick();
  if (!due || tick_wait_.pending) return;
  tick_timer_.expires_at(asio::steady_timer::time_point(*due));
  tick_timer_.async_wait(in(tick_wait_.memory, [this](const std::error_code& error) {
    tick_wait_.pending = false;
    if (error || sessions_.world() == nullptr) return;  // the new scene has no moving objects
    const Nanoseconds now = options_.clock();
    sessions_.tick(now);
    sessions_.spent_otherwise(options_.clock() - now);
    log_.tell_of_world(sessions_, now);
    await_tick();
  }));
  tick_wait_.pending = true;
}

SceneSummary SceneHost::count() const {
  return {name_, sessions_.counters(), datagrams_.unsent(),
          static_cast<std::uint32_t>(sessions_.size()), datagrams_.answer_times()};
}

SceneSummary SceneHost::summary() {
  if (!thread_.joinable()) return count();
  std::promise<SceneSummary> counted;
  post([this, &counted] {
    try {
      counted.set_value(count());
    } catch (const std::exception&) {
      counted.set_exception(std::current_exception());
    }
  });
  return counted.get_future().get();
}

}  // namespace feltwire
