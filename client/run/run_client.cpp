#include "client/run/run_client.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>

#include "client/run/crash_release.hpp"
#include "client/run/debts.hpp"
#include "client/run/device_words.hpp"
#include "client/run/emergency_key.hpp"
#include "client/run/hold_time.hpp"
#include "client/run/out_of_memory_reserve.hpp"
#include "client/run/output_files.hpp"
#include "client/run/rehearsal.hpp"
#include "client/run/report.hpp"
#include "client/run/status_line.hpp"
#include "client/run/supervise_session.hpp"
#include "client/run/wait_until_ready.hpp"
#include "client/transport/encoder.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/units.hpp"
#include "core/base/visible_text.hpp"
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

/// Returns the error that ended the run too early, or an empty text. `refusal`: the server's reason
/// to refuse a new session permanently. A complete run fails if its device failed.
std::string error_of(const LoopResult& result, const std::string& refusal, const Servo& servo) {
  switch (result.end) {
    case EndReason::server_goodbye:
      return "the server ended the session" + goodbye_error(result.goodbye);
    case EndReason::server_silent:
      return "the server has fallen silent; is it still running?";
    case EndReason::refused:
      return refusal;
    case EndReason::failed:
      return std::string("the servo loop broke off: ") +
             (result.stood_still ? stood_still_text(result) : "the system gave no timer");
    default:
      return trouble_text(servo.device_trouble(), result.duration);
  }
}

/// Prints the last lines of a run and returns the exit code. `error`: reason for an early end.
int conclude(const RunOptions& options, const Servo& servo, const LoopResult& result,
             const std::string& error, bool reported) {
  const ServoStatistics& s = servo.statistics();
  std::printf(
      "%.1f s, %llu samples, %llu datagrams lost, round trip p50 %.0f us p99 %.0f us, largest "
      "force %.2f N%s, bound violations %llu%s%s%s%s%s%s%s\n",
      result.duration, static_cast<unsigned long long>(s.samples),
      static_cast<unsigned long long>(servo.lost()), 1e-3 * s.round_trip.quantile(0.5),
      1e-3 * s.round_trip.quantile(0.99), s.max_force, no_force_text(s).c_str(),
      static_cast<unsigned long long>(servo.port().violations()),
      feel_text(servo.measures()).c_str(), cut_text(s).c_str(),
      device_faults_text(s.device_faults, s.jumps).c_str(),
      result.end == EndReason::device_ended ? "; the device has no more readings" : "",
      error.empty() ? "" : ("; " + visible(error)).c_str(), reported ? ", report in " : "",
      reported ? visible(options.report->string()).c_str() : "");
  if (const std::string slow =
          slow_device(result.device, servo.parameters().servo_period, result.paced);
      !slow.empty())
    std::fprintf(stderr, "feltwire-client: warning: %s\n", slow.c_str());
  if (error.empty()) return 0;
  std::fprintf(stderr, "feltwire-client: %s\n", visible(error).c_str());
  return 1;
}

/// Warns once if the servo thread lacks real-time scheduling.
void warn_of_missing(const RealTime& granted, int priority) noexcept {
  try {
    if (const std::string less = missing(granted, priority); !less.empty())
      std::fprintf(stderr, "feltwire-client: warning: the servo may be late now and then: %s\n",
                   less.c_str());
  } catch (const std::exception&) {  // no memory for the warning
  }
}

/// The data that the threads of a run share.
struct Run : ServoTask {
  using ServoTask::ServoTask;
  static constexpr std::size_t kSessionRoom = 4, kStatusRoom = 16;
  std::unique_ptr<Records> records;
  std::optional<Changes> changes;  // changes that an admin requests
  Ring<SessionAddress> sessions{kSessionRoom};
  Ring<LiveStatus> statuses{kStatusRoom};
  Ring<const FetchedScene*> fetched{kSessionRoom};
};

/// Returns the metadata of MCAP files.
std::map<std::string, std::string> about(const RunOptions& options) {
  return {{"client", options.name},
          {"device", options.device_kind},
          {"mode", std::string(options.parameters.mode)},
          {"scene", options.scene},
          {"server", to_string(options.server.endpoint)},
          {"version", version()}};
}

std::optional<RecordingTarget> recording_target(const RunOptions& options) {
  if (!options.record) return std::nullopt;
  return RecordingTarget{
      .file = *options.record, .limits = options.record_limits, .about = about(options)};
}

std::optional<FlightTarget> flight_target(const RunOptions& options) {
  if (!options.flight_recorder) return std::nullopt;
  return FlightTarget{*options.flight_recorder, about(options), options.flight_recorder_required};
}

/// Returns the device's key within this process.
std::string key_of(const RunOptions& options, const DeviceSpec& spec) {
  return options.device_kind + ' ' + spec.name;
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

std::shared_ptr<Run> make_run(const RunOptions& options, const control::JoinAccepted& accepted,
                              std::unique_ptr<Device> device,
                              std::shared_ptr<Transport> transport) {
  ServoOptions servo = options.servo;
  servo.owed = debt_of(key_of(options, device->spec()));
  servo.observes = options.role == Role::observer;
  if (servo.leads) {
    servo.seats = accepted.seats;
    servo.seat = seat_of(options.robot, accepted.seats);
  }
  // The stiffness of the objects around a robot is unknown. It may differ from the stiffness of the
  // scene.
  servo.scene_stiffness = servo.leads ? 0.0 : accepted.stiffness;
  auto run =
      std::make_shared<Run>(std::move(device), std::move(transport), accepted.parameters, servo);
  run->records = std::make_unique<Records>(
      Records::Files{recording_target(options), options.view, servo.observes, options.on_view,
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
                  .wanted = &run->changes->wanted()};
  const Nanoseconds period = from_seconds(accepted.parameters.servo_period);
  run->priority = never_sleeps(run->options.busy_poll, period) ? 0 : kServoPriority;
  run->let_go_after = options.let_go_after;
  return run;
}

/// Returns the session whose whole geometry the client fetches. Returns 0 if the client does not
/// need it.
std::uint64_t fetching_session(const control::JoinAccepted& accepted, const RunOptions& options) {
  const bool fetches = options.whole_surfaces && accepted.lists_surfaces &&
                       accepted.parameters.local_model && feels(options.role);
  return fetches ? accepted.session : 0;
}

/// Collects the figures of a run. Precondition: its servo thread has ended.
RunFigures figures_of(const Run& run, const RealTime& real_time, const Address& server) {
  const ServoStatistics& s = run.servo.statistics();
  RunFigures figures{.end = run.result.end,
                     .duration = run.result.duration,
                     .servo_period = run.servo.parameters().servo_period,
                     .hold_time = run.servo.parameters().hold_time,
                     .samples = s.samples,
                     .missed_deadlines = run.result.missed_deadlines,
                     .wakeup_late = run.result.wakeup_late,
                     .datagrams = s.datagrams,
                     .lost = run.servo.lost(),
                     .too_long = run.transport->statistics().too_long,
                     .shortened = run.transport->statistics().shortened,
                     .round_trip = s.round_trip,
                     .real_time = real_time,
                     .server = server};
  if (const ClockEstimate& clock = run.servo.server_clock(); clock.known())
    figures.jitter = std::max(clock.jitter_up(), clock.jitter_down());
  return figures;
}

/// A port may be user code. If it throws, the report contains the error and all other data.
std::string port_report(const DatagramPort& port) {
  try {
    return port.report();
  } catch (const std::exception& error) {
    return std::string("the port failed to report: ") + error.what();
  }
}

void write_report(const std::filesystem::path& file, const RunDescription& described,
                  const Run& run) {
  write_whole(file, report_json(described, run.servo, run.transport->statistics(), run.result,
                                port_report(run.transport->port())));
}

/// Writes the report. Tries twice, because the second attempt may succeed.
void write_report_surely(const std::filesystem::path& file, const RunDescription& described,
                         const Run& run) {
  try {
    write_report(file, described, run);
  } catch (const std::exception&) {
    write_report(file, described, run);
  }
}

/// Ends the program at once after a thread could not be joined. The thread may still use objects
/// that a normal exit destroys.
[[noreturn]] void end_at_once(int code) {
  std::fflush(stdout);
  std::fflush(stderr);
  std::_Exit(code);
}

}  // namespace

int run_client(std::unique_ptr<Device> device, const RunOptions& options) {
  forbid_core_dumps();
  end_without_random_numbers();
  std::signal(SIGPIPE, SIG_IGN);  // a closed terminal must not end the session suddenly
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit must fail like a full disk
  // Check all files before the request to the server.
  if (options.report) check_writable(*options.report);
  if (const auto target = recording_target(options)) check_writable(numbered(*target, 1));
  if (options.view) check_writable(*options.view);
  const Signals signals(options.flight_recorder.has_value());
  OutOfMemoryReserve reserve;
  if (!wait_until_ready(*device, signals)) return 0;

  control::JoinRequest wanted{options.name, options.scene, device->spec(), options.parameters,
                              options.role};
  if (const Nanoseconds tick = device->longest_tick(); tick.count() > 0)
    wanted.parameters.servo_period = seconds(tick);
  choose_hold_time(wanted.parameters, options.hold_time_follows);
  wanted.tool = options.tool;
  wanted.version = version();
  if (options.role != Role::observer) wanted.takes = options.takes;
  const GrantLimits limits{.hold_time = feels(options.role) ? options.longest_hold_time
                                                            : kLongestGrantedHold};
  Joined joined = join(options.server, wanted, kControlTimeout, limits);
  const auto transport = std::make_shared<Transport>(
      SessionAddress{joined.datagrams, joined.accepted.session, joined.keys},
      joined.accepted.parameters, device->spec().rotation_sensed > 0,
      options.open_port ? options.open_port(joined.datagrams) : open_udp_port(joined.datagrams),
      PositionScale{device->spec().position_resolution, joined.accepted.stiffness});
  joined.keys = {};  // the transport has copies of the required keys
  // The server has a session for this client from here on. Report every failure to the server.
  std::shared_ptr<Run> all;
  std::optional<Reconnector> reconnector;
  std::optional<SceneFetch> fetch;
  std::optional<CrashRelease> crash_release;
  std::optional<RehearsalThread> rehearsal;
  std::optional<ServoThread> thread;
  try {
    require_heard(joined.accepted.parameters, joined.accepted.silence_timeout);
    device->begin(joined.accepted.start_position, joined.accepted.start_normal);
    if (const auto warning = encoder_warning(device->spec(), joined.accepted.stiffness))
      std::fprintf(stderr, "feltwire-client: warning: %s\n", visible(*warning).c_str());
    all = make_run(options, joined.accepted, std::move(device), transport);
    wanted.parameters = joined.accepted.parameters;
    RejoinOptions rejoin;
    if (options.servo.leads) rejoin.seats = joined.accepted.seats;
    reconnector.emplace(options.server, wanted, all->sessions, rejoin);
    fetch.emplace(options.server, all->fetched,
                  SceneFetchOptions{.servo_period = joined.accepted.parameters.servo_period});
    crash_release.emplace(all->guard, options.flight_recorder.has_value());
    if (options.rehearses)
      rehearsal.emplace(all->servo.spec(), joined.accepted.parameters, all->servo.options(),
                        joined.accepted.stiffness);
    thread.emplace(all);
  } catch (...) {
    transport->goodbye();
    throw;
  }
  // The hand may hold a force from here on. Throw nothing until the thread has ended.
  RealTime real_time = thread->real_time();
  warn_of_missing(real_time, all->priority);
  {
    EmergencyKey keys(options.emergency, STDIN_FILENO);
    if (keys.descriptor() >= 0)
      std::fputs("feltwire-client: the space bar takes all force off at once\n", stderr);
    supervise_session(signals, *thread, all->statuses, *all->records, *all->changes, *reconnector,
                      *fetch, fetching_session(joined.accepted, options), keys);
  }
  const bool ended = thread->end();
  LoopResult& result = all->result;
  if (!reconnector->refusal().empty() && !result.stood_still) result.end = EndReason::refused;

  all->records->finish();
  std::string fault = error_of(result, reconnector->refusal(), all->servo);
  if (const auto& overdraft = all->servo.overdraft())
    fault += (fault.empty() ? "" : "; ") + text(*overdraft, all->servo.spec());
  if (!fault.empty())
    if (const auto file = all->records->write_flight_record(fault))
      fault += "; flight record: " + file->string();
  bool reported = false, failed = all->records->failed();
  reserve.stand_in();
  const std::optional<Rehearsal> rehearsed = rehearsal ? rehearsal->finish() : std::nullopt;
  try {
    keep_debt(key_of(options, all->servo.spec()), all->servo.owed());
    std::string check;
    if (options.on_end) check = options.on_end(figures_of(*all, real_time, joined.datagrams));
    if (options.report)
      write_report_surely(
          *options.report,
          {options.name, options.scene, to_string(options.server.endpoint), options.device_kind,
           real_time, joined.accepted.stiffness, options.busy_poll, all->records->sight(),
           joined.accepted.tool, joined.accepted.version, check, &all->changes->done(),
           &all->records->flight_records(), fetch->refusal(),
           ended && options.true_energy ? std::optional(options.true_energy()) : std::nullopt,
           rehearsed},
          *all);
    reported = options.report.has_value();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-client: the report is lost: %s\n",
                 visible(error.what()).c_str());
    failed = true;
  }
  const int ending = conclude(options, all->servo, result, fault, reported);
  int code = failed ? 1 : ending;
  if (options.on_exit) code = options.on_exit(code);
  if (!ended || reconnector->asking() || fetch->asking()) end_at_once(code);
  return code;
}

}  // namespace feltwire
