// Our own client's servo loop against our own server.

#include <arpa/inet.h>
#include <sys/prctl.h>

#include <cmath>
#include <memory>
#include <thread>

#include "client/servo_loop.hpp"
#include "tests/bench/net/measures.hpp"

namespace feltwire::netbench {
namespace {

constexpr double kSecondsForEach = 4.0;  // of the settings' seconds: one client makes few samples
constexpr unsigned long kDefaultSlack = 50'000, kLeastSlack = 1;  // [ns]

/// Above the table and in it, in turns.
class DippingDevice final : public Device {
 public:
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override {
    const double t = std::chrono::duration<double>(now).count();
    return {.pose = {.position = {0, 0, -0.0505 + 0.0015 * std::sin(8.0 * t)}}};
  }
  Command write(const Command& on_hand) noexcept override { return on_hand; }

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
};

struct Run {
  double late_p50, late_p99, round_trip_p50, round_trip_p99;
};

Run run(const Settings& settings, const Way& way) {
  HostOptions host;
  host.kind = way.server;
  host.scene_file = settings.scene;
  host.cores = {kServerCore};
  host.redundancy = settings.redundancy;
  const HostProcess process(host);
  const Target& target = process.targets().front();

  DippingDevice device;
  Transport transport(local(target.port), target.sessions.front(), settings.redundancy, false);
  Servo servo(device.spec(), join_request(settings.redundancy).parameters);
  LoopOptions options;
  options.duration = Nanoseconds(std::llround(kSecondsForEach * settings.seconds * 1e9));
  options.busy_poll = way.busy_poll;
  const Event stop;
  const auto result = std::make_unique<LoopResult>();
  std::thread thread([&] {
    pin_to(kLoadCore);
    prctl(PR_SET_TIMERSLACK, way.slack);
    run_servo_loop(device, servo, transport, options, stop, {}, *result);
  });
  thread.join();
  const Histogram& round_trip = servo.statistics().round_trip;
  return {1e-3 * result->wakeup_late.quantile(0.5), 1e-3 * result->wakeup_late.quantile(0.99),
          1e-3 * round_trip.quantile(0.5), 1e-3 * round_trip.quantile(0.99)};
}

}  // namespace

std::vector<ServoFigures> servo(const Settings& settings) {
  constexpr Nanoseconds kBounded = std::chrono::microseconds(50);
  const std::array ways = {
      Way{"sleeps, timer slack 50 us (default)", kDefaultSlack, Nanoseconds(0),
          HostKind::ours_sleeping},
      Way{"sleeps, timer slack 1 ns (ours)", kLeastSlack, Nanoseconds(0), HostKind::ours_sleeping},
      Way{"both --busy-poll 50", kLeastSlack, kBounded, HostKind::ours_bounded},
      Way{"both --busy-poll inf", kLeastSlack, kForever, HostKind::ours_spinning}};
  std::vector<std::vector<Run>> runs(ways.size());
  for (int round = 0; round < settings.rounds; ++round)
    for (std::size_t i = 0; i < ways.size(); ++i) runs[i].push_back(run(settings, ways[i]));
  std::vector<ServoFigures> figures;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const auto over = [&](double Run::*value) {
      std::vector<double> values;
      for (const Run& r : runs[i]) values.push_back(r.*value);
      return median(values);
    };
    figures.push_back({ways[i].how, over(&Run::late_p50), over(&Run::late_p99),
                       over(&Run::round_trip_p50), over(&Run::round_trip_p99)});
  }
  return figures;
}

}  // namespace feltwire::netbench
