#include "gateway/remote_scene/remote_scene.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <asio/post.hpp>
#include <utility>

#include "client/run/observed_scene.hpp"
#include "client/servo/servo_thread.hpp"
#include "client/transport/transport.hpp"
#include "core/base/visible_text.hpp"
#include "core/build_info/build_info.hpp"
#include "core/device/device_spec.hpp"
#include "gateway/remote_scene/seen_picture.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr const char* kName = "feltwire-view";
constexpr double kPeriod = 0.01;   // [s] of samples, and so of views
constexpr int kBetweenLooks = 16;  // [ms] at the views that have come
constexpr std::size_t kRoom = 64;  // views: half a second of them

/// An observer's device: it is held by nobody, and is nowhere but at its place.
class Eye final : public Device {
 public:
  Eye() : spec_(builtin_device("simulated")) { spec_.name = kName; }
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override { return {}; }
  Command write(const Command&) noexcept override { return {}; }
  void release() noexcept override {}

 private:
  DeviceSpec spec_;
};

/// A sample a view. An observer feels nothing, so that nothing needs to come in time.
SessionParameters observer_parameters() {
  SessionParameters parameters;
  parameters.servo_period = kPeriod;
  parameters.redundancy = 0;
  return parameters;
}

/// The state that the threads share. A thread that hangs is left behind with it.
struct Look : ServoTask {
  using ServoTask::ServoTask;
  Ring<TimedView> views{kRoom};
};

std::string why(const LoopResult& result) {
  if (result.end == EndReason::server_silent) return "the server gives no answer";
  if (result.end != EndReason::server_goodbye) return "the observer's thread came to a stop";
  return result.goodbye == GoodbyeReason::shutting_down ? "the server is shutting down"
         : result.goodbye == GoodbyeReason::evicted
             ? "an admin of the server ended the observer's session, or its token was revoked"
             : "the server ended the observer's session; its log says why";
}

}  // namespace

RemoteScene::RemoteScene(Scene scene, const ServerAccess& server, const LookOptions& options)
    : name_(scene.name()), server_(server), options_(options) {
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

void RemoteScene::describe(asio::io_context& back,
                           std::function<void(std::vector<HandDescription>)> done) {
  std::vector<HandDescription> hands;
  {
    const std::lock_guard lock(mutex_);
    hands = hands_;
  }
  asio::post(back, [hands = std::move(hands), done = std::move(done)]() mutable {
    done(std::move(hands));
  });
}

std::optional<std::string> RemoteScene::out_of_sight() const {
  const std::lock_guard lock(mutex_);
  return hidden_;
}

/// What has been seen is as old as the session: viewers are shown no hand where none is known of.
void RemoteScene::hide(std::string why) {
  std::string text = "Scene " + name_ + " is not seen: " + std::move(why);
  const std::lock_guard lock(mutex_);
  hidden_ = std::move(text);
  picture_.hands.clear();
  hands_.clear();
  picture_.version = current_.version;
  picture_.time = monotonic_now();
  fresh_ = true;
}

void RemoteScene::show(const ObservedScene& seen) {
  const std::lock_guard lock(mutex_);
  draw(seen, *current_.scene, picture_);
  hands_ = hands_of(seen, *current_.scene);
  picture_.version = current_.version;
  picture_.time = monotonic_now();
  fresh_ = true;
  hidden_.reset();
}

/// Until it is stopped. Whatever fails is tried again: a token may be renewed, a server repaired.
void RemoteScene::run() {
  auto wait = options_.first_wait;
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
    if (joined_) wait = options_.first_wait;
    hide(reason);
    if (std::exchange(said, reason) != reason || joined_)
      spdlog::warn("scene {}: {}; it is looked for again", visible(name_), visible(reason));
    pollfd stopped{stop_.descriptor(), POLLIN, 0};
    ::poll(&stopped, 1, static_cast<int>(wait.count()));
    wait = std::min(2 * wait, options_.longest_wait);
  }
}

/// Joins, and shows what is to be seen until the session has ended. Returns why it has. Throws what
/// join() does.
std::string RemoteScene::look_on() {
  auto eye = std::make_unique<Eye>();
  control::JoinRequest request{kName, name_, eye->spec(), observer_parameters(), Role::observer};
  request.version = version();
  request.figures = true;
  const Joined joined = join(server_, request, options_.timeout);
  const SessionParameters& parameters = joined.accepted.parameters;
  const auto transport = std::make_shared<Transport>(
      SessionAddress{joined.datagrams, joined.accepted.session, joined.keys}, parameters,
      eye->spec().rotation_sensed > 0, open_udp_port(joined.datagrams));
  std::optional<ServoThread> thread;
  std::shared_ptr<Look> task;
  try {
    ServoOptions servo;
    servo.observes = true;
    task = std::make_shared<Look>(std::move(eye), transport, parameters, servo);
    task->options.silence_timeout = from_seconds(joined.accepted.silence_timeout);
    task->priority = ServoTask::kNoRealTime;
    task->outputs.views = &task->views;
    thread.emplace(task);
  } catch (...) {
    transport->goodbye();
    throw;
  }
  joined_ = true;
  spdlog::info("scene {}: looks on", visible(name_));
  ObservedScene seen;
  TimedView shown;
  std::array<pollfd, 2> waiting{
      {{stop_.descriptor(), POLLIN, 0}, {thread->over_descriptor(), POLLIN, 0}}};
  while (!stop_.is_set() && !thread->over()) {
    bool news = false;
    while (task->views.pop(shown)) {
      seen.take(shown.view);
      news = true;
    }
    if (news) show(seen);
    ::poll(waiting.data(), waiting.size(), kBetweenLooks);
  }
  thread->end();
  return why(task->result);
}

}  // namespace feltwire
