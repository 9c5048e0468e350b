#include "client/observer/observer_session.hpp"

#include <utility>

#include "client/device/device.hpp"
#include "client/transport/transport.hpp"
#include "core/base/ring.hpp"
#include "core/build_info/build_info.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/session/role.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kRoom = 64;  // largest number of waiting views, about half a second

/// Device of an observer. It has no hand and never moves.
class ObserverDevice final : public Device {
 public:
  explicit ObserverDevice(const std::string& name) : spec_(builtin_device("simulated")) {
    spec_.name = name;
  }
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override { return {}; }
  Command write(const Command&) noexcept override { return {}; }
  void release() noexcept override {}

 private:
  DeviceSpec spec_;
};

/// Returns session parameters with one sample per view. No sample is repeated, because an observer
/// needs no force and a lost sample does no harm.
SessionParameters observer_parameters(double period) {
  SessionParameters parameters;
  parameters.servo_period = period;
  parameters.redundancy = 0;
  return parameters;
}

std::string why(const LoopResult& result) {
  if (result.end == EndReason::server_silent) return "the server gives no answer";
  if (result.end != EndReason::server_goodbye) return "the observer's thread came to a stop";
  return result.goodbye == GoodbyeReason::shutting_down ? "the server is shutting down"
         : result.goodbye == GoodbyeReason::evicted
             ? "an admin of the server ended the observer's session, or its token was revoked"
             : "the server ended the observer's session; its log says why";
}

}  // namespace

/// State that the thread shares with its owner. The thread keeps this state alive if it hangs.
struct ObserverSession::Task : ServoTask {
  using ServoTask::ServoTask;
  Ring<TimedView> views{kRoom};
};

ObserverSession::ObserverSession(FleetRoute& route, const ObserverRequest& request) {
  auto eye = std::make_unique<ObserverDevice>(request.name);
  control::JoinRequest wanted{request.name, request.scene, eye->spec(),
                              observer_parameters(request.period), Role::observer};
  wanted.version = version();
  wanted.figures = true;
  // An observer has no force feedback, so the server may choose the hold time.
  const Joined joined = route.join(wanted, request.timeout, {.hold_time = kLongestGrantedHold});
  const SessionParameters& parameters = joined.accepted.parameters;
  const auto transport = std::make_shared<Transport>(
      SessionAddress{joined.datagrams, joined.accepted.session, joined.keys}, parameters,
      eye->spec().rotation_sensed > 0, open_udp_port(joined.datagrams));
  try {
    ServoOptions servo;
    servo.observes = true;
    task_ = std::make_shared<Task>(std::move(eye), transport, parameters, servo);
    task_->options.silence_timeout = from_seconds(joined.accepted.silence_timeout);
    task_->priority = ServoTask::kNoRealTime;
    task_->let_go_after = parameters.hold_time;  // any time is safe: an observer gives no force
    task_->outputs.views = &task_->views;
    thread_.emplace(task_);
  } catch (...) {
    transport->goodbye();
    throw;
  }
}

ObserverSession::~ObserverSession() = default;

bool ObserverSession::take(TimedView& view) noexcept { return task_->views.pop(view); }

std::string ObserverSession::end() {
  thread_->end();
  return why(task_->result);
}

}  // namespace feltwire
