#include "gateway/page_hand/page_hand.hpp"

#include <poll.h>

#include <cerrno>
#include <utility>

#include "client/servo/servo_thread.hpp"
#include "client/transport/transport.hpp"
#include "core/bounding/method.hpp"
#include "core/build_info/build_info.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kJoinTime{3000};
constexpr const char* kName = "page hand";

/// A pointer device that also owns its message ring, together with the page. So the ring exists as
/// long as the device.
class OwnPointerMessages final : public Device {
 public:
  OwnPointerMessages(const PointerHandOptions& options,
                     std::shared_ptr<Ring<PointerMessage>> messages)
      : messages_(std::move(messages)), device_(options, *messages_) {}
  const DeviceSpec& spec() const override { return device_.spec(); }
  void begin(const Vec3& position, const Vec3& normal) override { device_.begin(position, normal); }
  DeviceReading read(Nanoseconds now) noexcept override { return device_.read(now); }
  Command write(const Command& on_hand) noexcept override { return device_.write(on_hand); }
  void release() noexcept override { device_.release(); }
  const PointerDevice& device() const { return device_; }

 private:
  std::shared_ptr<Ring<PointerMessage>> messages_;
  PointerDevice device_;
};

std::string why(const LoopResult& result, bool neglected) {
  switch (result.end) {
    case EndReason::device_ended:
      return neglected ? "the page said nothing for a second, so the hand let go"
                       : "the page let go of the hand";
    case EndReason::server_goodbye:
      return result.goodbye == GoodbyeReason::shutting_down ? "the server is shutting down"
             : result.goodbye == GoodbyeReason::evicted
                 ? "an admin ended the hand's session, or its token was revoked"
             : result.goodbye == GoodbyeReason::disturbing
                 ? "the hand broke the simulation of what moves; press and move more gently"
                 : "the server ended the hand's session; its log says why";
    case EndReason::server_silent:
      return "the scene gave no answer";
    default:
      return "the hand's thread came to a stop; the machine may be overloaded";
  }
}

/// Returns the usual session parameters with the bounding method `mode`. An empty `mode` means the
/// usual method. A method that evaluates the scene runs at the server.
SessionParameters parameters_with(const std::string& mode) {
  SessionParameters parameters = usual_parameters();
  if (mode.empty()) return parameters;
  parameters.mode = mode;
  if (stands_beside_scene(bounding_method(mode))) {
    parameters.side = BoundingSide::server;
    parameters.local_model = false;
  }
  return parameters;
}

control::JoinRequest request_of(const std::string& client, const std::string& scene,
                                const DeviceSpec& spec, const std::string& mode) {
  control::JoinRequest request{client, scene, spec, parameters_with(mode), Role::pointer};
  request.version = version();
  return request;
}

/// Waits until the servo loop has ended.
void wait_for_end_of(const ServoThread& thread) {
  pollfd over{thread.over_descriptor(), POLLIN, 0};
  while (!thread.over())
    if (::poll(&over, 1, -1) < 0 && errno != EINTR) std::this_thread::yield();
}

}  // namespace

PointerHandOptions page_hand_options() {
  PointerHandOptions options;
  options.spec = builtin_device("simulated");
  options.spec.name = kName;
  return options;
}

ClientPageHand::ClientPageHand(const ServerAccess& server, const web::PageHandRequest& request)
    : server_(server), scene_(request.scene), client_(request.client), mode_(request.mode) {
  server_.credentials.token = request.token;
}

ClientPageHand::~ClientPageHand() {
  release();
  if (thread_.joinable()) thread_.join();
}

void ClientPageHand::start() noexcept {
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::exception& error) {
    end(error.what());
  }
}

web::PageHand::Status ClientPageHand::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void ClientPageHand::point(const Vec3& target) noexcept {
  // If the ring is full, this target is lost. The next message has a newer target.
  messages_->push({.kind = PointerMessage::Kind::to, .target = target});
}

void ClientPageHand::release() noexcept {
  // If the ring is full, this message is lost. This is harmless: either no servo loop runs, or the
  // loop ends one second after the last message.
  messages_->push({.kind = PointerMessage::Kind::let_go});
}

void ClientPageHand::become(Status status) noexcept {
  const std::lock_guard lock(mutex_);
  status_ = std::move(status);
}

void ClientPageHand::end(const char* reason) noexcept {
  try {
    become({.state = State::released, .reason = reason});
  } catch (const std::exception&) {  // no memory to copy the reason
    become({.state = State::released});
  }
  over_.store(true);
}

void ClientPageHand::run() noexcept {
  try {
    end(hold().c_str());
  } catch (const std::exception& error) {
    end(error.what());
  }
}

/// Runs a session until it ends. Returns the reason of the end.
std::string ClientPageHand::hold() {
  const PointerHandOptions options = page_hand_options();
  auto device = std::make_unique<OwnPointerMessages>(options, messages_);
  const PointerDevice& hand = device->device();
  // Nobody holds this device, so accept a longer hold time of the commands if the server grants it.
  const Joined joined = join(server_, request_of(client_, scene_, device->spec(), mode_), kJoinTime,
                             {.hold_time = kLongestGrantedHold});
  server_.credentials.token = {};  // erases the token, because it is a secret
  const SessionParameters& parameters = joined.accepted.parameters;
  const auto transport = std::make_shared<Transport>(
      SessionAddress{joined.datagrams, joined.accepted.session, joined.keys}, parameters,
      options.spec.rotation_sensed > 0, open_udp_port(joined.datagrams),
      PositionScale{options.spec.position_resolution, joined.accepted.stiffness});
  std::shared_ptr<ServoTask> task;
  std::optional<ServoThread> thread;
  try {
    device->begin(joined.accepted.start_position, joined.accepted.start_normal);
    ServoOptions servo = protect_hand(parameters);
    servo.scene_stiffness = joined.accepted.stiffness;
    task = std::make_shared<ServoTask>(std::move(device), transport, parameters, servo);
    task->options.silence_timeout = from_seconds(joined.accepted.silence_timeout);
    task->priority = ServoTask::kNoRealTime;
    task->let_go_after = parameters.hold_time;  // long, but nobody holds this device
    thread.emplace(task);
    become({.state = State::held,
            .session = joined.accepted.session,
            .start = hand.start(),
            .stiffness = options.hand.stiffness,
            .reach = options.reach});
  } catch (...) {
    thread.reset();
    transport->goodbye();
    throw;
  }
  wait_for_end_of(*thread);
  thread->end();
  return why(task->result, hand.neglected());
}

}  // namespace feltwire
