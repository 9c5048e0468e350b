#include "client/run/run_client.hpp"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>

#include "client/run/device_words.hpp"
#include "client/run/emergency_key.hpp"
#include "client/run/hand_run.hpp"
#include "client/run/out_of_memory_reserve.hpp"
#include "client/run/output_files.hpp"
#include "client/run/report.hpp"
#include "client/run/status_line.hpp"
#include "client/run/supervise_session.hpp"
#include "client/run/terminal_outlet.hpp"
#include "client/run/wait_until_ready.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

/// Prints the last lines of a run and returns the exit code. `error`: reason for an early end.
int conclude(const RunOptions& options, const Servo& servo, const LoopResult& result,
             const std::string& error, bool reported) {
  const ServoStatistics& s = servo.statistics();
  std::printf(
      "%.1f s, %llu samples, %llu datagrams lost, round trip p50 %.0f us p99 %.0f us, largest "
      "force %.2f N%s, bound violations %llu%s%s%s%s%s%s%s\n",
      result.duration, static_cast<unsigned long long>(s.samples),
      static_cast<unsigned long long>(servo.lost()), 1e-3 * s.replies.round_trip.quantile(0.5),
      1e-3 * s.replies.round_trip.quantile(0.99), s.max_force, no_force_text(s).c_str(),
      static_cast<unsigned long long>(servo.port().violations()),
      feel_text(servo.measures()).c_str(), cut_text(s).c_str(),
      device_faults_text(s.device.faults, s.device.jumps).c_str(),
      result.end == EndReason::device_ended ? "; the device has no more readings" : "",
      error.empty() ? "" : ("; " + visible(error)).c_str(), reported ? ", report in " : "",
      reported ? visible(options.files.report->string()).c_str() : "");
  if (const std::string slow =
          slow_device(result.device, servo.parameters().servo_period, result.paced);
      !slow.empty())
    std::fprintf(stderr, "feltwire-client: warning: %s\n", slow.c_str());
  if (error.empty()) return 0;
  std::fprintf(stderr, "feltwire-client: %s\n", visible(error).c_str());
  return 1;
}

/// Collects the figures of a run. Precondition: its servo thread has ended.
RunFigures figures_of(const HandRun& hand) {
  const RunTask& run = hand.task();
  const ServoStatistics& s = run.servo.statistics();
  RunFigures figures{.end = run.result.end,
                     .duration = run.result.duration,
                     .servo_period = run.servo.parameters().servo_period,
                     .hold_time = run.servo.parameters().hold_time,
                     .samples = s.samples,
                     .missed_deadlines = run.result.missed_deadlines,
                     .wakeup_late = run.result.wakeup_late,
                     .datagrams = s.replies.datagrams,
                     .lost = run.servo.lost(),
                     .too_long = run.transport->statistics().too_long,
                     .shortened = run.transport->statistics().shortened,
                     .round_trip = s.replies.round_trip,
                     .real_time = hand.real_time(),
                     .server = hand.server()};
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
                  const RunTask& run) {
  write_whole(file, report_json(described, run.servo, run.transport->statistics(), run.result,
                                port_report(run.transport->port())));
}

/// Writes the report. Tries twice, because the second attempt may succeed.
void write_report_surely(const std::filesystem::path& file, const RunDescription& described,
                         const RunTask& run) {
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
  if (options.files.report) check_writable(*options.files.report);
  if (const auto target = recording_target(options)) check_writable(numbered(*target, 1));
  if (options.files.view) check_writable(*options.files.view);
  const Signals signals(options.files.flight_recorder.has_value());
  OutOfMemoryReserve reserve;
  if (!wait_until_ready(*device, signals)) return 0;

  TerminalOutlet terminal;
  HandRun run(std::move(device), options, terminal, options.files.flight_recorder.has_value());
  {
    EmergencyKey keys(options.emergency, STDIN_FILENO);
    if (keys.descriptor() >= 0) terminal.say("the space bar takes all force off at once");
    supervise_session(signals, run.supervisor(), keys, terminal);
  }
  terminal.end_line();
  std::string fault = run.end();
  const RunTask& task = run.task();
  bool reported = false, failed = task.records->failed();
  reserve.stand_in();
  const std::optional<Rehearsal> rehearsed = run.rehearsal();
  try {
    std::string check;
    if (options.hooks.on_end) check = options.hooks.on_end(figures_of(run));
    if (options.files.report)
      write_report_surely(
          *options.files.report,
          {options.name, options.scene, to_string(options.server.endpoint), options.device_kind,
           run.real_time(), run.accepted().stiffness, options.busy_poll, task.records->sight(),
           run.accepted().tool, run.accepted().version, check, &task.changes->done(),
           &task.records->flight_records(), run.fetch().refusal(),
           run.servo_ended() && options.hooks.true_energy
               ? std::optional(options.hooks.true_energy())
               : std::nullopt,
           rehearsed},
          task);
    reported = options.files.report.has_value();
  } catch (const std::exception& error) {
    terminal.say(std::string("the report is lost: ") + error.what());
    failed = true;
  }
  const int ending = conclude(options, task.servo, task.result, fault, reported);
  int code = failed ? 1 : ending;
  if (options.hooks.on_exit) code = options.hooks.on_exit(code);
  if (!run.servo_ended()) end_at_once(code);
  return code;
}

}  // namespace feltwire
