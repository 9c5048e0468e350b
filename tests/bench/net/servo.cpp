// Measures our client's servo loop against our server.

#include <arpa/inet.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <ctime>
#include <memory>
#include <thread>

#include "client/servo/servo_loop.hpp"
#include "protocol/net/real_time.hpp"
#include "tests/bench/net/measures.hpp"

namespace feltwire::netbench {
namespace {

// times Settings::seconds, because one client makes few samples
constexpr double kSecondsForEach = 4.0;
constexpr unsigned long kDefaultSlack = 50'000, kLeastSlack = 1;  // [ns]

/// Alternates between positions above and inside the table.
class DippingDevice final : public Device {
 public:
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override {
    const double t = std::chrono::duration<double>(now).count();
    return {.pose = {.position = {0, 0, -0.0505 + 0.0015 * std::sin(8.0 * t)}}};
  }
  Command write(const Command& on_hand) noexcept override { return on_hand; }
  void release() noexcept override {}

 private:
  DeviceSpec spec_ = builtin_device("simulated");
};

Address local(std::uint16_t port) {
  Address address;
  auto& v4 = reinterpret_cast<sockaddr_in&>(address.storage);
  v4.sin_family = AF_INET;
  v4.sin_port = htons(port);
  v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.size = sizeof v4;
  return address;
}

struct Way {
  const char* how;
  unsigned long slack;  // [ns]
  Nanoseconds busy_poll;
  HostKind server;
  int priority = 0;  // priority of the client's thread
};

struct Run {
  double late_p50, late_p99, round_trip_p50, round_trip_p99, round_trip_p999;
};

Run run(const Settings& settings, const Way& way) {
  HostOptions host;
  host.kind = way.server;
  host.scene_file = settings.scene;
  host.cores = {kServerCore};
  host.redundancy = settings.redundancy;
  host.suite = settings.suite;
  const HostProcess process(host);
  const Target& target = process.targets().front();

  DippingDevice device;
  const SessionParameters parameters = join_request(settings.redundancy).parameters;
  const std::uint64_t session = target.sessions.front();
  Transport transport({local(target.port), session, session_keys(session, host.suite)}, parameters,
                      false);
  Servo servo(device.spec(), parameters);
  LoopOptions options;
  options.duration = Nanoseconds(std::llround(kSecondsForEach * settings.seconds * 1e9));
  options.busy_poll = way.busy_poll;
  const Event stop;
  const auto result = std::make_unique<LoopResult>();
  std::thread thread([&] {
    pin_to(kLoadCore);
    if (way.priority > 0) request_real_time(way.priority);
    prctl(PR_SET_TIMERSLACK, way.slack);
    run_servo_loop(device, servo, transport, options, stop, {}, *result);
  });
  thread.join();
  const Histogram& round_trip = servo.statistics().replies.round_trip;
  return {1e-3 * result->wakeup_late.quantile(0.5), 1e-3 * result->wakeup_late.quantile(0.99),
          1e-3 * round_trip.quantile(0.5), 1e-3 * round_trip.quantile(0.99),
          1e-3 * round_trip.quantile(0.999)};
}

/// Measures the machine's limit: the thread only waits for a timer.
Run bare_timer(const Settings& settings) {
  constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
  Histogram late;
  std::thread thread([&] {
    pin_to(kLoadCore);
    const int timer = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
    const Nanoseconds start = now();
    const auto spec = [](Nanoseconds time) {
      const auto whole = std::chrono::duration_cast<std::chrono::seconds>(time);
      return timespec{whole.count(), (time - whole).count()};
    };
    const itimerspec times{.it_interval = spec(kPeriod), .it_value = spec(start + kPeriod)};
    ::timerfd_settime(timer, TFD_TIMER_ABSTIME, &times, nullptr);
    const auto ticks = static_cast<std::int64_t>(kSecondsForEach * settings.seconds * 1e3);
    pollfd waiting{timer, POLLIN, 0};
    for (std::int64_t passed = 0; passed < ticks;) {
      ::poll(&waiting, 1, -1);
      const Nanoseconds woken = now();
      std::uint64_t count = 0;
      if (::read(timer, &count, sizeof count) != static_cast<ssize_t>(sizeof count)) break;
      passed += static_cast<std::int64_t>(count);
      late.record((woken - start - passed * kPeriod).count());
    }
    ::close(timer);
  });
  thread.join();
  return {1e-3 * late.quantile(0.5), 1e-3 * late.quantile(0.99), NAN, NAN, NAN};
}

}  // namespace

std::vector<ServoFigures> servo(const Settings& settings) {
  constexpr Nanoseconds kBounded = std::chrono::microseconds(50);
  const std::array ways = {
      Way{"sleeps, timer slack 50 us (default)", kDefaultSlack, Nanoseconds(0),
          HostKind::ours_sleeping},
      Way{"sleeps, timer slack 1 ns (ours)", kLeastSlack, Nanoseconds(0), HostKind::ours_sleeping},
      Way{"sleeps, both real-time", kLeastSlack, Nanoseconds(0), HostKind::ours_real_time,
          kServoPriority},
      Way{"--busy-poll 50, both real-time", kLeastSlack, kBounded, HostKind::ours_real_time,
          kServoPriority},
      Way{"--busy-poll 50, server inf", kLeastSlack, kBounded, HostKind::ours_spinning},
      Way{"--busy-poll inf, server inf", kLeastSlack, kForever, HostKind::ours_spinning}};
  std::vector<std::vector<Run>> runs(ways.size() + 1);
  for (int round = 0; round < settings.rounds; ++round) {
    for (std::size_t i = 0; i < ways.size(); ++i) runs[i].push_back(run(settings, ways[i]));
    runs.back().push_back(bare_timer(settings));
  }
  std::vector<ServoFigures> figures;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto over = [&](double Run::*value) {
      std::vector<double> values;
      for (const Run& r : runs[i]) values.push_back(r.*value);
      return median(values);
    };
    figures.push_back({i < ways.size() ? ways[i].how : "bare timerfd + poll", over(&Run::late_p50),
                       over(&Run::late_p99), over(&Run::round_trip_p50), over(&Run::round_trip_p99),
                       over(&Run::round_trip_p999)});
  }
  return figures;
}

}  // namespace feltwire::netbench
