// feltwire-client: one hand in one scene.

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <future>
#include <memory>
#include <system_error>
#include <thread>

#include "client/devices/replay.hpp"
#include "client/encoder.hpp"
#include "client/onlooker.hpp"
#include "client/options.hpp"
#include "client/rejoin.hpp"
#include "client/report.hpp"
#include "client/status_line.hpp"
#include "protocol/real_time.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kControlTimeout{3000};
constexpr int kHousekeeping = 50;             // [ms] between looks at the rings
constexpr std::size_t kLinkRoom = 1 << 13;    // datagrams on their way: 0.8 s at 10 kHz
constexpr std::size_t kRecordRoom = 1 << 14;  // rows: more than a second at 10 kHz

/// SIGINT and SIGTERM as a descriptor; blocked in all threads that are started from now on.
class Signals {
 public:
  Signals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    descriptor_ = ::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
    if (descriptor_ < 0)
      throw std::system_error(errno, std::generic_category(), "cannot watch signals");
  }
  ~Signals() { ::close(descriptor_); }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
};

std::unique_ptr<Device> make_hand(const ClientOptions& options, const HandTask& task) {
  return std::make_unique<SimulatedDevice>(
      SimulatedHandOptions{.spec = options.spec, .hand = {}, .task = task});
}

std::unique_ptr<Device> make_device(const ClientOptions& options) {
  if (const auto* replay = std::get_if<ReplayFile>(&options.device))
    return make_replay_device(replay->path, options.spec);
  return make_hand(options, std::get<HandTask>(options.device));
}

/// The same hand, begun where the scene says, unless the command line says it.
std::unique_ptr<Device> make_hand_at_start(const ClientOptions& options, HandTask task,
                                           const control::JoinAccepted& accepted) {
  if (!options.center_given) task.center = accepted.start_position;
  if (!options.normal_given) set_normal(task, accepted.start_normal);
  return make_hand(options, task);
}

int list(const ServerAccess& server) {
  std::printf("%-24s %8s %8s %8s\n", "scene", "port", "objects", "clients");
  for (const control::SceneEntry& scene : list_scenes(server, kControlTimeout))
    std::printf("%-24s %8u %8u %8u\n", scene.name.c_str(),
                unsigned{server.endpoint.port} + scene.port_offset, scene.objects, scene.sessions);
  return 0;
}

/// What is written down while the run goes on. Writing that fails is said once.
class Records {
 public:
  explicit Records(const ClientOptions& options) {
    if (options.record) recording_ = std::make_unique<RecordingFile>(*options.record);
    if (options.role == Role::observer) onlooker_ = std::make_unique<Onlooker>(options.view);
  }
  Ring<TickRecord>* rows() { return recording_ ? &rows_ : nullptr; }
  Ring<TimedView>* views() { return onlooker_ ? &onlooker_->views() : nullptr; }
  std::optional<SightCounts> sight() const {
    return onlooker_ ? std::optional(onlooker_->counts()) : std::nullopt;
  }
  void write() {
    try {
      if (recording_ && !failed_) recording_->write(rows_);
      if (onlooker_ && !failed_) onlooker_->look();
    } catch (const std::runtime_error& error) {
      failed_ = true;
      std::fprintf(stderr, "feltwire-client: %s\n", error.what());
    }
  }
  bool failed() const { return failed_; }

 private:
  std::unique_ptr<RecordingFile> recording_;
  Ring<TickRecord> rows_{kRecordRoom};
  std::unique_ptr<Onlooker> onlooker_;
  bool failed_ = false;
};

/// What the main thread does while the servo thread runs.
void look_after(const Signals& signals, Event& stop, const Event& finished,
                Ring<LiveStatus>& statuses, Records& records, Rejoiner& rejoiner) {
  StatusLine line;
  bool connected = true;
  std::array<pollfd, 2> waiting{
      {{signals.descriptor(), POLLIN, 0}, {finished.descriptor(), POLLIN, 0}}};
  bool running = true;
  while (running) {
    ::poll(waiting.data(), waiting.size(), kHousekeeping);
    signalfd_siginfo signal;
    while (::read(signals.descriptor(), &signal, sizeof signal) ==
           static_cast<ssize_t>(sizeof signal))
      stop.set();
    running = (waiting[1].revents & POLLIN) == 0;
    LiveStatus status;
    bool fresh = false;
    while (statuses.pop(status)) fresh = true;
    records.write();
    const auto sight = records.sight();
    if (fresh) line.show(status, sight ? text(*sight) : std::string());
    if (fresh) connected = status.connected;
    if (running) rejoiner.look(connected, Rejoiner::Clock::now());
    if (!rejoiner.refusal().empty()) stop.set();
  }
  line.end();
}

/// What is left to say of a run; the exit code. `refusal`: why it ended where another session was
/// refused for good.
int conclude(const ClientOptions& options, const Servo& servo, const LoopResult& result,
             const std::string& refusal) {
  const ServoStatistics& s = servo.statistics();
  std::printf(
      "%.1f s, %llu samples, %llu datagrams lost, round trip p50 %.0f us p99 %.0f us, largest "
      "force %.2f N, "
      "bound violations %llu%s%s\n",
      result.duration, static_cast<unsigned long long>(s.samples),
      static_cast<unsigned long long>(servo.lost()), 1e-3 * s.round_trip.quantile(0.5),
      1e-3 * s.round_trip.quantile(0.99), s.max_force,
      static_cast<unsigned long long>(servo.port().violations()),
      options.report ? ", report in " : "", options.report ? options.report->c_str() : "");
  switch (result.end) {
    case EndReason::server_goodbye:
      std::fprintf(stderr, "feltwire-client: the server ended the session%s\n",
                   result.goodbye == GoodbyeReason::shutting_down ? ": it is shutting down"
                   : result.goodbye == GoodbyeReason::flooding
                       ? ": it was sent far more samples than it granted"
                       : "");
      return 1;
    case EndReason::server_silent:
      std::fprintf(stderr, "feltwire-client: the server has fallen silent; is it still running?\n");
      return 1;
    case EndReason::refused:
      std::fprintf(stderr, "feltwire-client: %s\n", refusal.c_str());
      return 1;
    case EndReason::failed:
      std::fprintf(stderr, "feltwire-client: the servo loop broke off: the system gave no timer\n");
      return 1;
    default:
      return 0;
  }
}

int run(const ClientOptions& options) {
  if (options.list) return list(options.server);
  // Whatever can go wrong on this side does so before the server is bothered.
  if (options.report) check_writable(*options.report);
  if (options.record) check_writable(*options.record);
  if (options.view) check_writable(*options.view);
  std::unique_ptr<Device> device = make_device(options);
  const Signals signals;

  control::JoinRequest wanted{options.name, options.scene, device->spec(), options.parameters,
                              options.role};
  wanted.tool = options.tool;
  Joined joined = join(options.server, wanted, kControlTimeout);
  Transport transport(
      {joined.datagrams, joined.accepted.session, joined.keys}, joined.accepted.parameters,
      device->spec().rotation_sensed > 0,
      options.link ? std::make_unique<TwoWayLink>(*options.link, 0, kLinkRoom) : nullptr,
      {device->spec().position_resolution, joined.accepted.stiffness}, options.dscp);
  joined.keys = {};  // the transport has what is still needed of them
  // From here on the server knows of us: whatever fails, it is told.
  try {
    if (const auto* task = std::get_if<HandTask>(&options.device))
      device = make_hand_at_start(options, *task, joined.accepted);
    Servo servo(device->spec(), joined.accepted.parameters, options.servo);
    if (const auto warning = encoder_warning(device->spec(), joined.accepted.stiffness))
      std::fprintf(stderr, "feltwire-client: warning: %s\n", warning->c_str());
    Records records(options);

    constexpr std::size_t kSessionRoom = 4;
    Ring<SessionAddress> sessions(kSessionRoom);
    wanted.parameters = joined.accepted.parameters;
    Rejoiner rejoiner(options.server, wanted, sessions);
    const LoopOptions loop{.duration = from_seconds(options.duration),
                           .silence_timeout = from_seconds(joined.accepted.silence_timeout),
                           .patience = from_seconds(options.patience),
                           .rejoined = &sessions,
                           .busy_poll = busy_poll_time(options.busy_poll)};
    const Nanoseconds period = from_seconds(joined.accepted.parameters.servo_period);
    const int priority = never_sleeps(loop.busy_poll, period) ? 0 : kServoPriority;
    constexpr std::size_t kStatusRoom = 16;
    Ring<LiveStatus> statuses(kStatusRoom);
    const LoopOutputs outputs{
        .status = &statuses, .record = records.rows(), .views = records.views()};
    Event stop, finished;
    const auto result = std::make_unique<LoopResult>();
    std::promise<RealTime> granted;
    std::thread thread([&] {
      granted.set_value(request_real_time(priority));
      run_servo_loop(*device, servo, transport, loop, stop, outputs, *result);
      finished.set();
    });
    const RealTime real_time = granted.get_future().get();
    if (const std::string less = missing(real_time, priority); !less.empty())
      std::fprintf(stderr, "feltwire-client: warning: the servo may be late now and then: %s\n",
                   less.c_str());
    look_after(signals, stop, finished, statuses, records, rejoiner);
    thread.join();
    if (!rejoiner.refusal().empty()) result->end = EndReason::refused;

    if (options.report)
      write_whole(*options.report,
                  report_json({options.name, options.scene, to_string(options.server.endpoint),
                               options.device_kind, real_time, joined.accepted.stiffness,
                               options.busy_poll, records.sight(), joined.accepted.tool},
                              servo, transport.statistics(), *result, transport.link()));
    const int code = conclude(options, servo, *result, rejoiner.refusal());
    return records.failed() ? 1 : code;
  } catch (...) {
    transport.goodbye();
    throw;
  }
}

}  // namespace
}  // namespace feltwire

int main(int argc, char** argv) {
  feltwire::forbid_core_dumps();
  std::signal(SIGPIPE, SIG_IGN);  // a closed terminal does not end a hand's session halfway
  try {
    const auto parsed = feltwire::parse_options(argc, argv);
    if (const int* code = std::get_if<int>(&parsed)) return *code;
    return feltwire::run(std::get<feltwire::ClientOptions>(parsed));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feltwire-client: %s\n", error.what());
    return 1;
  }
}
