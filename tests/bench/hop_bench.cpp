// hop/CASE: the server's work between a hand and its robot, without system calls.
// hop/lead: a leading sample. The server opens it, takes the state, and seals the robot's target
//   and the hand's answer.
// hop/state: a robot's state. The server opens it and takes the state.
// The clock runs from the datagram's arrival until all resulting datagrams are ready.

#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <functional>

#include "client/followers/robot_datagrams.hpp"
#include "client/transport/datagram_session.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire::hop_bench {
namespace {

constexpr std::uint64_t kHand = 0x700, kRobot = 0x800;
constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);

SessionKeys keys(std::uint64_t session) {
  SessionKeys keys{.suite = preferred_suite()};
  keys.up.fill(static_cast<std::uint8_t>(session >> 4));
  keys.down.fill(static_cast<std::uint8_t>(session >> 5));
  return keys;
}

Scene seat() {
  Object far_away;
  far_away.name = "far";
  far_away.shape = Sphere{0.1};
  far_away.pose.position = Vec3(0.0, 0.0, -50.0);
  far_away.material = {.stiffness = 1000.0};
  Scene scene("seat", {far_away});
  scene.set_seats({RemoteSeat{}});
  return scene;
}

/// A hand and a robot in contact, each in its own session.
struct Link {
  Scene scene = seat();
  SceneSessions server{scene, std::chrono::hours(1), 8, nullptr, {.sample_rate = 1e6}};
  SessionParameters parameters = usual_parameters();
  DatagramSession hand{kHand, keys(kHand), parameters, false};
  RobotDatagrams robot{kRobot, keys(kRobot)};
  Peer hand_peer{.address = {}, .length = 1}, robot_peer{.address = {}, .length = 2};
  DatagramBuffer answer, target;
  Nanoseconds now = std::chrono::seconds(1);
  Sample sample;
  Lead lead;
  RobotState state;

  Link() {
    const DeviceSpec device = builtin_device("simulated");
    server.answer(control::JoinRequest{"bench", scene.name(), device, parameters, Role::operator_},
                  kHand, keys(kHand), now);
    server.answer(control::JoinRequest{"bench", scene.name(), device, parameters, Role::follower},
                  kRobot, keys(kRobot), now);
    state.force = Vec3(0.0, 0.0, 5.0);
    state.contact = {.surface = 1, .touching = true, .normal = Vec3::UnitZ(), .stiffness = 800.0};
    for (int n = 0; n < 4; ++n) {
      lead.deadman = n > 1;
      follow();
      take(lead_on());
    }
  }
  /// Returns the hand's next datagram.
  Bytes lead_on() {
    now += kPeriod;
    ++sample.index;
    sample.client_time = now;
    sample.pose.position.x() = 0.01 * std::sin(1e-3 * static_cast<double>(sample.index));
    lead.hand_work += 1e-6;
    return hand.pack(sample, {}, lead);
  }
  Bytes say() {
    ++state.index;
    state.time = now;
    return robot.pack(state);
  }
  /// Returns the time [s] of `work`.
  template <typename Work>
  static double timed(const Work& work) {
    const auto begun = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  }
  double take(Bytes datagram) {
    return timed([&] {
      benchmark::DoNotOptimize(server.receive(datagram, hand_peer, now, answer));
      Peer to;
      benchmark::DoNotOptimize(server.forward(0, now, to, target));
    });
  }
  double follow() {
    const Bytes datagram = say();
    return timed([&] {
      benchmark::DoNotOptimize(server.receive(datagram, robot_peer, now, answer));
      Peer to;
      benchmark::DoNotOptimize(server.forward(0, now, to, target));
    });
  }
  bool engaged() const { return server.link_state(0) == LinkState::engaged; }
};

void run(benchmark::State& state, bool lead) {
  Link link;
  for (auto _ : state) {
    const double robot = link.follow();
    const double hand = link.take(link.lead_on());
    state.SetIterationTime(lead ? hand : robot);
  }
  if (!link.engaged()) state.SkipWithError("the hand leads no robot");
}

BENCHMARK_CAPTURE(run, lead, true)->Name("hop/lead")->UseManualTime();
BENCHMARK_CAPTURE(run, state, false)->Name("hop/state")->UseManualTime();

}  // namespace
}  // namespace feltwire::hop_bench
