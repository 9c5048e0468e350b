#include "gateway/remote_scene/remote_scene.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <utility>

#include "client/observer/observer_session.hpp"
#include "client/observer/query_thread.hpp"
#include "client/run/observed_scene.hpp"
#include "client/transport/control_dialogue.hpp"
#include "client/transport/listing.hpp"
#include "core/base/visible_text.hpp"
#include "gateway/remote_scene/seen_picture.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr const char* kName = "feltwire-view";
constexpr int kBetweenLooks = 16;  // [ms] longest wait between two checks for new views
constexpr int kBetweenAsks = 500;  // [ms] wait between two requests for data that the views lack

}  // namespace

RemoteScene::RemoteScene(Scene scene, const ServerAccess& server, const LookOptions& options)
    : name_(scene.name()), route_(server), options_(options) {
  current_ = {std::make_shared<const Scene>(std::move(scene)), 1, 0, std::nullopt};
  hide("it is being joined");
}

RemoteScene::~RemoteScene() { stop(); }

void RemoteScene::start() {
  thread_ = std::thread([this] { run(); });
}

void RemoteScene::stop() {
  stop_.set();
  if (thread_.joinable()) thread_.join();
}

void RemoteScene::reload(Scene scene) {
  auto next = std::make_shared<const Scene>(std::move(scene));
  const std::lock_guard lock(mutex_);
  current_.scene = std::move(next);
  ++current_.version;
  adopted_.reset();
}

SceneInView::CurrentScene RemoteScene::current_scene() const {
  const std::lock_guard lock(mutex_);
  return current_;
}

bool RemoteScene::take_picture(Picture& picture) {
  const std::lock_guard lock(mutex_);
  if (fresh_) picture = picture_;
  return std::exchange(fresh_, false);
}

void RemoteScene::describe(PostBack back, std::function<void(std::vector<HandDescription>)> done) {
  std::vector<HandDescription> hands;
  {
    const std::lock_guard lock(mutex_);
    hands = hands_;
  }
  back([hands = std::move(hands), done = std::move(done)]() mutable { done(std::move(hands)); });
}

std::optional<std::string> RemoteScene::out_of_sight() const {
  const std::lock_guard lock(mutex_);
  return hidden_;
}

control::SceneTimes RemoteScene::server_times() const {
  const std::lock_guard lock(mutex_);
  return server_times_;
}

/// Removes all hands from the picture and stores the reason. Old views would show hands in an
/// unknown state.
void RemoteScene::hide(std::string why) {
  std::string text = "Scene " + name_ + " is not seen: " + std::move(why);
  const std::lock_guard lock(mutex_);
  hidden_ = std::move(text);
  picture_.hands.clear();
  hands_.clear();
  told_.clear();
  server_times_ = {};
  adopted_.reset();
  picture_.version = current_.version;
  picture_.time = monotonic_now();
  fresh_ = true;
}

void RemoteScene::show(const ObservedScene& seen) {
  const std::lock_guard lock(mutex_);
  draw(seen, *current_.scene, told_, picture_);
  near_.add(current_.scene, seen, told_, picture_);
  hands_ = hands_of(seen, *current_.scene, told_, told_at_);
  picture_.version = current_.version;
  picture_.time = monotonic_now();
  fresh_ = true;
  hidden_.reset();
}

/// Requests the data that the views lack (sessions and materials), until `over` is set. Stops if
/// the server is too old for these requests, or if its answers are impossible.
void RemoteScene::ask_on(const Event& over) {
  std::optional<ControlDialogue> server;
  int wait = kBetweenAsks;
  while (!over.is_set()) {
    try {
      if (!server) server.emplace(route_.host(), options_.timeout);
      ask_once(*server);
      wait = kBetweenAsks;
    } catch (const LastingError& error) {
      spdlog::warn("scene {}: names, bounding methods and materials are not known: {}",
                   visible(name_), visible(error.what()));
      return;
    } catch (const std::exception& error) {
      spdlog::debug("scene {}: {}", visible(name_), visible(error.what()));
      server.reset();
      wait = std::min(2 * wait, static_cast<int>(options_.longest_wait.count()));
    }
    wait_for(over, wait);
  }
}

void RemoteScene::ask_once(ControlDialogue& server) {
  ListRoom room(options_.list_room);
  auto all = described_sessions(server, name_, room);
  std::erase_if(all, [](const auto& session) { return session.role == Role::observer; });
  std::vector<control::SessionDescription> told(std::make_move_iterator(all.begin()),
                                                std::make_move_iterator(all.end()));
  {
    const std::lock_guard lock(mutex_);
    told_ = std::move(told);
    told_at_ = monotonic_now();
  }
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  const auto scene =
      server.ask_for<control::SceneDescription>(control::DescribeScene{name_, kNone});
  {
    const std::lock_guard lock(mutex_);
    server_times_ = scene.times;
    if (adopted_ == std::pair(scene.version, scene.changes)) return;
  }
  const DescribedMaterials described =
      described_materials(server, name_, current_scene().scene->objects().size());
  adopt(described.scene, described.materials);
}

/// Applies the server's materials and gravity, because an admin of the server may have changed
/// them.
void RemoteScene::adopt(const control::SceneDescription& told,
                        std::span<const Material> materials) {
  const CurrentScene before = current_scene();
  std::optional<Scene> changed = with_materials(*before.scene, materials);
  const std::lock_guard lock(mutex_);
  // reload() has replaced the scene meanwhile, so wait for the next answer.
  if (current_.version != before.version) return;
  if (adopted_ && adopted_->first != told.version)
    spdlog::warn("scene {}: the server has reloaded it; send SIGHUP to read its file again",
                 visible(name_));
  if (changed || current_.gravity != told.gravity) ++current_.changes;
  if (changed) current_.scene = std::make_shared<const Scene>(*std::move(changed));
  current_.gravity = told.gravity;
  adopted_ = {told.version, told.changes};
}

/// Observes the scene until stop(). Retries after every failure, because a token may be renewed or
/// a server repaired.
void RemoteScene::run() {
  Backoff backoff(options_.first_wait, options_.longest_wait, random_seed());
  std::string said;
  while (!stop_.is_set()) {
    joined_ = false;
    std::string reason;
    try {
      reason = look_on();
    } catch (const std::exception& error) {
      reason = error.what();
    }
    if (stop_.is_set()) return;
    if (joined_) backoff.reset();
    hide(reason);
    if (std::exchange(said, reason) != reason || joined_)
      spdlog::warn("scene {}: {}; it is looked for again", visible(name_), visible(reason));
    wait_for(stop_, static_cast<int>(backoff.next().count()));
  }
}

/// Joins the scene, and shows the views until the session ends. Returns the reason for the end.
/// Throws the exceptions of join().
std::string RemoteScene::look_on() {
  ObserverSession session(route_, {.name = kName, .scene = name_, .timeout = options_.timeout});
  joined_ = true;
  spdlog::info("scene {}: looks on", visible(name_));
  const QueryThread asking([this](const Event& over) { ask_on(over); });
  ObservedScene seen;
  TimedView shown;
  std::array<pollfd, 2> waiting{
      {{stop_.descriptor(), POLLIN, 0}, {session.over_descriptor(), POLLIN, 0}}};
  while (!stop_.is_set() && !session.over()) {
    bool news = false;
    while (session.take(shown)) {
      seen.take(shown.view);
      news = true;
    }
    if (news) show(seen);
    ::poll(waiting.data(), waiting.size(), kBetweenLooks);
  }
  return session.end();
}

}  // namespace feltwire
