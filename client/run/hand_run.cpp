#include "client/run/hand_run.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <map>
#include <vector>

#include "client/run/debts.hpp"
#include "client/run/device_words.hpp"
#include "client/run/hold_time.hpp"
#include "client/transport/encoder.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/units.hpp"
#include "core/build_info/build_info.hpp"
#include "protocol/net/busy_poll.hpp"

namespace feltwire {
namespace {

std::string goodbye_error(GoodbyeReason reason) {
  switch (reason) {
    case GoodbyeReason::shutting_down:
      return ": it is shutting down";
    case GoodbyeReason::flooding:
      return ": it was sent far more samples than it granted";
    case GoodbyeReason::evicted:
      return ": it was evicted: by an admin, because its token is good no more or its tool is not "
             "in "
             "the scene, or because nothing was heard of it";
    case GoodbyeReason::failed:
      return ": it failed in this scene; its log says why";
    case GoodbyeReason::disturbing:
      return ": the hand broke the simulation of what moves; press and move more gently";
    default:
      return "";
  }
}

/// Returns a text such as "no tick came for 5.2 ms, and the device was let go: ...".
std::string stood_still_text(const LoopResult& result) {
  std::array<char, 64> time{};
  std::snprintf(time.data(), time.size(), "no tick came for %.1f ms", kMilli * result.still_for);
  const bool in_device = result.still_in != DeviceCall::none;
  return std::string(time.data()) + ", and the device was let go: " +
         (in_device ? std::string(enum_name(kDeviceCallNames, result.still_in)) +
                          "() of the device did not return"
                    : "the servo thread was not run, or computed for too long") +
         " (--let-go-after, docs/devices.md)";
}

/// Returns a text for a session that the server ended, or did not answer any more.
std::string lost_by_text(EndReason reason, GoodbyeReason goodbye) {
  return reason == EndReason::server_goodbye
             ? "the server ended the session" + goodbye_error(goodbye)
             : "the server has fallen silent; is it still running?";
}

/// Returns the error of a run that had no session when its duration was over, or an empty text.
std::string lost_text(const LoopResult& result) {
  if (result.end != EndReason::duration || !(result.lost_for > 0.0)) return {};
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "the session was lost at %.1f s, and not found again: ",
                std::max(0.0, result.duration - result.lost_for));
  return text.data() + lost_by_text(result.lost_by, result.goodbye);
}

/// Returns the error that ended the run too early, or an empty text. `refusal`: the server's reason
/// to refuse a new session permanently. A complete run fails if its device failed, or if its
/// session was lost.
std::string error_of(const LoopResult& result, const std::string& refusal, const Servo& servo) {
  switch (result.end) {
    case EndReason::server_goodbye:
    case EndReason::server_silent:
      return lost_by_text(result.end, result.goodbye);
    case EndReason::refused:
      return refusal;
    case EndReason::failed:
      return std::string("the servo loop broke off: ") +
             (result.stood_still ? stood_still_text(result) : "the system gave no timer");
    default:
      break;
  }
  std::string trouble = trouble_text(servo.device_trouble(), result.duration);
  return trouble.empty() ? lost_text(result) : trouble;
}

std::optional<FlightTarget> flight_target(const RunOptions& options) {
  if (!options.files.flight_recorder) return std::nullopt;
  return FlightTarget{*options.files.flight_recorder, recording_about(options),
                      options.files.flight_recorder_required};
}

/// Returns the number of the robot's seat. Throws SessionError with the names of all seats.
std::uint8_t seat_of(const std::string& robot, const std::vector<std::string>& seats) {
  if (robot.empty()) return 0;
  const auto found = std::ranges::find(seats, robot);
  if (found != seats.end()) return static_cast<std::uint8_t>(found - seats.begin());
  std::string names;
  for (const std::string& seat : seats) names += (names.empty() ? "" : ", ") + seat;
  throw SessionError("--robot: the scene has no seat '" + robot + "'; " +
                     (names.empty() ? "leave --robot out" : "its seats are: " + names));
}

/// `owed` [J]: the debt with which the device's last run in this process ended.
std::shared_ptr<RunTask> make_task(const RunOptions& options, const control::JoinAccepted& accepted,
                                   double owed, std::unique_ptr<Device> device,
                                   std::shared_ptr<Transport> transport) {
  ServoOptions servo = options.servo;
  servo.owed = owed;
  servo.observes = options.role == Role::observer;
  if (servo.leads) {
    servo.seats = accepted.seats;
    servo.seat = seat_of(options.robot, accepted.seats);
  }
  // The stiffness of the objects around a robot is unknown. It may differ from the stiffness of the
  // scene.
  servo.scene_stiffness = servo.leads ? 0.0 : accepted.stiffness;
  auto run = std::make_shared<RunTask>(std::move(device), std::move(transport), accepted.parameters,
                                       servo);
  run->records = std::make_unique<Records>(Records::Files{
      recording_target(options), options.files.view, servo.observes, options.hooks.on_view,
      flight_target(options), accepted.parameters.servo_period});
  run->changes.emplace(Changes::Client{run->device->spec(), accepted.parameters, servo,
                                       run->transport->port(), options.takes});
  run->options = {.duration = from_seconds(options.duration),
                  .silence_timeout = from_seconds(accepted.silence_timeout),
                  .patience = from_seconds(options.patience),
                  .rejoined = &run->sessions,
                  .changes = &run->changes->ready(),
                  .fetched = &run->fetched,
                  .busy_poll = busy_poll_time(options.busy_poll)};
  run->outputs = {.status = &run->statuses,
                  .record = run->records->rows(),
                  .views = run->records->views(),
                  .wanted = &run->changes->wanted(),
                  .listener = options.hooks.listener};
  const Nanoseconds period = from_seconds(accepted.parameters.servo_period);
  run->priority = never_sleeps(run->options.busy_poll, period) ? 0 : kServoPriority;
  run->let_go_after = options.hold.let_go_after;
  return run;
}

/// Returns the session whose whole geometry the client fetches. Returns 0 if the client does not
/// need it.
std::uint64_t fetching_session(const control::JoinAccepted& accepted, const RunOptions& options) {
  const bool fetches = options.whole_surfaces && accepted.lists_surfaces &&
                       accepted.parameters.local_model && feels(options.role);
  return fetches ? accepted.session : 0;
}

/// Warns once if the servo thread lacks real-time scheduling.
void warn_of_missing(const RealTime& granted, int priority, RunOutlet& outlet) noexcept {
  try {
    if (const std::string less = missing(granted, priority); !less.empty())
      outlet.say("warning: the servo may be late now and then: " + less);
  } catch (const std::exception&) {  // no memory for the warning
  }
}

}  // namespace

std::map<std::string, std::string> recording_about(const RunOptions& options) {
  return {{"client", options.name},
          {"device", options.device_kind},
          {"mode", std::string(options.parameters.mode)},
          {"scene", options.scene},
          {"server", to_string(options.server.endpoint)},
          {"version", version()}};
}

std::optional<RecordingTarget> recording_target(const RunOptions& options) {
  if (!options.files.record) return std::nullopt;
  return RecordingTarget{.file = *options.files.record,
                         .limits = options.files.record_limits,
                         .about = recording_about(options)};
}

HandRun::HandRun(std::unique_ptr<Device> device, const RunOptions& options, RunOutlet& outlet,
                 bool takes_sigusr1)
    : options_(options), outlet_(outlet), takes_sigusr1_(takes_sigusr1), route_(options.server) {
  control::JoinRequest wanted{options.name, options.scene, device->spec(), options.parameters,
                              options.role};
  if (const Nanoseconds tick = device->longest_tick(); tick.count() > 0)
    wanted.parameters.servo_period = seconds(tick);
  choose_hold_time(wanted.parameters, options.hold.follows_period);
  wanted.tool = options.tool;
  wanted.version = version();
  if (options.role != Role::observer) wanted.takes = options.takes;
  const GrantLimits limits{.hold_time =
                               feels(options.role) ? options.hold.longest : kLongestGrantedHold};
  Joined joined = options.hooks.join ? options.hooks.join(wanted)
                                     : route_.join(wanted, kControlTimeout, limits);
  accepted_ = joined.accepted;
  datagrams_ = joined.datagrams;
  const auto transport = std::make_shared<Transport>(
      SessionAddress{datagrams_, accepted_.session, joined.keys}, accepted_.parameters,
      device->spec().rotation_sensed > 0,
      options.hooks.open_port ? options.hooks.open_port(datagrams_) : open_udp_port(datagrams_),
      PositionScale{device->spec().position_resolution, accepted_.stiffness});
  joined.keys = {};  // the transport has copies of the required keys
  // The server has a session for this client from here on. Report every failure to the server.
  try {
    begin(std::move(device), wanted, transport);
  } catch (...) {
    transport->goodbye();
    throw;
  }
  // The hand may hold a force from here on. Throw nothing until the thread has ended.
  real_time_ = thread_->real_time();
  warn_of_missing(real_time_, task_->priority, outlet_);
}

void HandRun::begin(std::unique_ptr<Device> device, control::JoinRequest& wanted,
                    std::shared_ptr<Transport> transport) {
  require_heard(accepted_.parameters, accepted_.silence_timeout);
  device->begin(accepted_.start_position, accepted_.start_normal);
  if (const auto warning = encoder_warning(device->spec(), accepted_.stiffness))
    outlet_.say("warning: " + *warning);
  device_name_ = options_.device_kind + ' ' + device->spec().name;
  owed_ = debt_of(device_name_);
  task_ = make_task(options_, accepted_, owed_, std::move(device), std::move(transport));
  wanted.parameters = accepted_.parameters;
  RejoinOptions rejoin;
  if (options_.servo.leads) rejoin.seats = accepted_.seats;
  reconnector_.emplace(route_, wanted, task_->sessions, rejoin);
  fetch_.emplace(route_.host(), task_->fetched,
                 SceneFetchOptions{.servo_period = accepted_.parameters.servo_period});
  crash_release_.emplace(task_->guard, takes_sigusr1_);
  if (options_.rehearses)
    rehearsal_.emplace(task_->servo.spec(), accepted_.parameters, task_->servo.options(),
                       accepted_.stiffness);
  thread_.emplace(task_);
  supervisor_.emplace(SessionSupervisor::Parts{*thread_, task_->statuses, *task_->records,
                                               *task_->changes, *reconnector_, *fetch_},
                      fetching_session(accepted_, options_), outlet_);
}

HandRun::~HandRun() {
  try {
    end();
  } catch (const std::exception&) {  // no memory for its texts; the servo thread has ended
  }
}

const std::string& HandRun::end() {
  if (error_) return *error_;
  error_.emplace();
  ended_ = thread_->end();
  LoopResult& result = task_->result;
  if (!reconnector_->refusal().empty() && !result.stood_still) result.end = EndReason::refused;
  task_->records->finish();
  settle_debt(device_name_, owed_, task_->servo.owed());
  std::string& fault = *error_;
  fault = error_of(result, reconnector_->refusal(), task_->servo);
  if (const auto& overdraft = task_->servo.overdraft())
    fault += (fault.empty() ? "" : "; ") + text(*overdraft, task_->servo.spec());
  if (!fault.empty())
    if (const auto file = task_->records->write_flight_record(fault))
      fault += "; flight record: " + file->string();
  return fault;
}

std::optional<Rehearsal> HandRun::rehearsal() {
  return rehearsal_ ? rehearsal_->finish() : std::nullopt;
}

}  // namespace feltwire
