#include "server/scene/scene_host.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <future>
#include <stdexcept>

#include "protocol/net/clock.hpp"
#include "protocol/net/listen_error.hpp"
#include "protocol/net/post.hpp"
#include "protocol/net/real_time.hpp"
#include "protocol/net/udp_socket.hpp"
#include "server/scene/scene_batch.hpp"

namespace feltwire {
namespace {

// Turns of busy polling between two looks at the timers: some 10 us if no datagram comes.
constexpr unsigned kTurnsBetweenLooks = 32;
// Between checks for sessions that must end.
constexpr std::chrono::milliseconds kSoonest{10}, kLatest{100};
constexpr int kSocketBuffer =
    1 << 20;  // [bytes] so that a burst of some 5000 samples waits and is not lost

}  // namespace

SceneHost::SceneHost(Scene scene, const SceneHostOptions& options)
    : name_(scene.name()),
      objects_(static_cast<std::uint32_t>(scene.objects().size())),
      scene_(std::make_shared<const Scene>(std::move(scene))),
      recorded_(options.events != nullptr),
      silence_timeout_(options.silence_timeout),
      busy_poll_(options.busy_poll),
      real_time_(options.real_time),
      clock_(options.clock),
      ended_(options.ended),
      sessions_(*scene_, options.silence_timeout, options.max_sessions, options.line,
                options.limits),
      batch_(std::make_unique<Batch>()) {
  sessions_.log_to(options.events);
  publish_scene();
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

SceneHost::~SceneHost() { stop(); }

/// Posts to the scene's thread, which sees between two answers that a handler waits.
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
    closing_ = true;  // the thread ends even if the rest fails
    say(sessions_.shut_down());
    publish();
  });
  thread_.join();
}

/// An answer that is still pending. The asking thread makes it, so that the scene's thread needs no
/// memory for it.
struct SceneHost::PendingAnswer {
  control::Message request;
  Completion completion;
  control::Message answer = control::Refused{control::RefusalCode::shutting_down,
                                             "the server is shutting down; join another"};
  control::Message failure =
      control::Refused{control::RefusalCode::failed, "the server failed at this; its log says why"};
};

void SceneHost::ask(control::Message request, std::uint64_t id, const SessionKeys& keys,
                    asio::io_context& back, Completion completion) {
  auto pending =
      std::make_shared<PendingAnswer>(PendingAnswer{std::move(request), std::move(completion)});
  post([this, pending = std::move(pending), id, keys, &back] {
    try {
      if (!closing_) pending->answer = sessions_.answer(pending->request, id, keys, clock_());
      if (auto* named = std::get_if<control::Counters>(&pending->answer))
        named->counters.push_back({"unsent", unsent_});
      if (auto* described = std::get_if<control::SceneDescription>(&pending->answer))
        described->times.answers = answers_;
    } catch (const std::exception& error) {
      spdlog::error("scene {}: a request was refused, the server failed at it: {}", name_,
                    error.what());
      pending->answer = std::move(pending->failure);
    }
    publish_size();
    post_patiently(post_to(back), [pending] { pending->completion(std::move(pending->answer)); });
    await_tick();
    publish();
  });
}

void SceneHost::reload(Scene scene) {
  post([this, next = std::make_shared<const Scene>(std::move(scene))]() mutable {
    if (closing_) return;
    std::vector<SceneSessions::GoodbyeDatagram> goodbyes;
    try {
      goodbyes = sessions_.enter(*next, clock_());
    } catch (const std::exception& error) {
      return spdlog::error(
          "scene {}: the server failed to enter the reloaded scene: {}; the scene "
          "stays as it was",
          name_, error.what());
    }
    say(goodbyes);
    if (!goodbyes.empty())
      spdlog::info("scene {}: sessions that ended, for it has their tool no more: {}", name_,
                   goodbyes.size());
    scene_ = std::move(next);
    publish_scene();
    objects_ = static_cast<std::uint32_t>(scene_->objects().size());
    publish();  // a session may have lost its tool
    world_log_.begin_anew();
    await_tick();
  });
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
  ChangeOutcome outcome = sessions_.change(change, clock_());
  if (auto* refused = std::get_if<control::Refused>(&outcome)) return std::move(*refused);
  auto& made = std::get<Changed>(outcome);
  if (made.scene != nullptr) scene_ = std::move(made.scene);
  if (std::holds_alternative<MaterialChange>(change) ||
      std::holds_alternative<GravityChange>(change))
    publish_scene();
  return std::move(made.what);
}

void SceneHost::publish_scene() noexcept {
  const std::lock_guard lock(published_);
  current_ = {scene_, sessions_.scene_version(), sessions_.live_changes(), sessions_.gravity()};
}

void SceneHost::evict(std::uint64_t session) {
  post([this, session] {
    if (closing_) return;
    say(sessions_.evict(session));
    publish();
  });
}

SceneInView::CurrentScene SceneHost::current_scene() const {
  const std::lock_guard lock(published_);
  return current_;
}

void SceneHost::describe(PostBack back, std::function<void(std::vector<HandDescription>)> done) {
  post([this, back = std::move(back), done = std::move(done)]() mutable {
    if (closing_) return;
    back([hands = sessions_.describe(), done = std::move(done)]() mutable {
      done(std::move(hands));
    });
  });
}

/// Draws a picture if a viewer waits for one. Without memory there is no picture.
void SceneHost::draw(PictureExchange& pictures, Nanoseconds now) noexcept {
  if (!pictures.wanted()) return;
  try {
    Picture& picture = pictures.picture();
    picture.version = sessions_.scene_version();
    sessions_.draw(picture, now);
    pictures.give();
  } catch (const std::exception&) {
  }
}

/// Writes a check once a second, for a replay to compare.
void SceneHost::check(Nanoseconds now) noexcept {
  constexpr std::chrono::seconds kBetween{1};
  if (!recorded_ || now - checked_at_ < kBetween) return;
  checked_at_ = now;
  sessions_.check(now);
}

void SceneHost::tell_ended() {
  if (ended_) ended_({sessions_.ended().begin(), sessions_.ended().end()});
  sessions_.forget_ended();
}

void SceneHost::ask_for_real_time() {
  const int priority = busy_poll_ == kForever ? 0 : kScenePriority;
  if (const std::string less = missing(request_real_time(priority), priority); !less.empty())
    spdlog::warn("scene {}: answers may be late now and then: {}", name_, less);
}

/// Runs the scene's thread.
void SceneHost::run() {
  if (real_time_) ask_for_real_time();
  while (!closing_) {
    try {
      turn();
    } catch (const std::exception& error) {
      recover(error);
    }
  }
}

/// The silence timer always waits, so Asio never runs out of work.
void SceneHost::turn() {
  if (!watching_) await_silence();
  await_tick();
  if (busy_poll_.count() > 0) spin();
  if (closing_) return;
  if (has_datagrams()) {  // already taken, so the socket will not wake for them
    io_.poll();
    if (!closing_) serve();
    return;
  }
  if (!waiting_) await_datagrams();
  io_.run_one();
}

/// After an exception the state of the scene is unknown, so its sessions end. The scene then takes
/// new sessions. Other scenes are not affected.
void SceneHost::recover(const std::exception& failure) noexcept {
  constexpr std::chrono::milliseconds kPause{10};  // no busy loop if it fails again at once
  try {
    if (const auto times = failures_.count(1, clock_()))
      spdlog::error(
          "scene {}: the server failed in it: {} ({} times since the last line); its sessions end, "
          "the scene goes on",
          name_, failure.what(), *times);
    say(sessions_.fail());
    publish();
  } catch (const std::exception&) {
    // The sessions ended without a goodbye, or the next turn reports their end.
  }
  std::this_thread::sleep_for(kPause);
}

/// Exchanges datagrams until none has come for the time of busy polling. Posted handlers and the
/// timer have their turn in between.
void SceneHost::spin() {
  Nanoseconds quiet_since = clock_();
  for (unsigned turn = 1; !closing_; ++turn) {
    if (turn % kTurnsBetweenLooks == 0 || posts_wait()) io_.poll();
    if (closing_) return;
    if (sessions_.next_tick()) sessions_.tick(clock_());
    std::optional<Nanoseconds> until;
    if (exchange(until) > 0) {
      quiet_since = kForever;
    } else if (busy_poll_ != kForever) {
      const Nanoseconds now = clock_();
      quiet_since = std::min(quiet_since, now);
      if (now - quiet_since >= busy_poll_) return;
    }
  }
}

void SceneHost::await_datagrams() {
  socket_.async_wait(asio::ip::udp::socket::wait_read,
                     in(datagram_wait_, [this](const std::error_code& error) {
                       waiting_ = false;
                       if (!error) serve();
                     }));
  waiting_ = true;
}

void SceneHost::await_silence() {
  // A flooding session must end soon even if the silence timeout is long.
  silence_timer_.expires_after(std::clamp<Nanoseconds>(silence_timeout_ / 4, kSoonest, kLatest));
  silence_timer_.async_wait(in(silence_wait_, [this](const std::error_code& error) {
    watching_ = false;
    if (error) return;
    await_silence();
    const Nanoseconds now = clock_();
    say(sessions_.expire(now));
    publish();
    tell_of_load(now);
    check(now);
    draw(now);
  }));
  watching_ = true;
}

/// Steps the moving bodies when due, with or without datagrams, as long as there is a session.
void SceneHost::await_tick() {
  const auto due = sessions_.next_tick();
  if (!due || ticking_) return;
  tick_timer_.expires_at(asio::steady_timer::time_point(*due));
  tick_timer_.async_wait(in(tick_wait_, [this](const std::error_code& error) {
    ticking_ = false;
    if (error || sessions_.world() == nullptr) return;  // the reloaded scene has no moving objects
    const Nanoseconds now = clock_();
    sessions_.tick(now);
    sessions_.spent_otherwise(clock_() - now);
    tell_of_world(now);
    await_tick();
  }));
  ticking_ = true;
}

void SceneHost::tell_of_world(Nanoseconds now) {
  const World& world = *sessions_.world();
  const WorldNews news{world.counters(), sessions_.ticks_dropped(), world.tick()};
  for (const std::string& line : world_log_.lines(news, now))
    spdlog::warn("scene {}: {}", name_, line);
}

void SceneHost::tell_of_load(Nanoseconds now) {
  for (const std::string& line : load_log_.lines(sessions_.share().slow(), sessions_.shed(), now))
    spdlog::warn("scene {}: {}", name_, line);
}

SceneSummary SceneHost::count() const {
  return {name_, sessions_.counters(), unsent_, static_cast<std::uint32_t>(sessions_.size()),
          answers_};
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
