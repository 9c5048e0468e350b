// A session in virtual time must equal a real session. With an ideal network the forces must equal
// a loop without a network. The fault counters must be correct, and the bound must always hold.

#include "sim/measure/network_run.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>

#include "sim/measure/experiment.hpp"

namespace feltwire::network_run_test {
namespace {

constexpr double kStiffness = 1500.0;  // [N/m]

Scene floor(double friction = 0.0, double stiffness = kStiffness) {
  Object object{
      .name = "floor",
      .shape = Plane{},
      .pose = {},
      .material = {
          .stiffness = stiffness, .static_friction = friction, .dynamic_friction = friction}};
  return Scene("floor", {object});
}

NetworkRunOptions sliding(BoundingSide side, const char* link) {
  NetworkRunOptions options;
  options.hand.spec = builtin_device("simulated");
  options.hand.task.path = HandPath::slide;
  options.parameters.side = side;
  options.link = parse_link(link);
  options.duration = 1.5;
  return options;
}

/// Runs the loop without datagrams. A command is one sample old, as over a link without delay.
std::vector<ExperimentSample> direct(const Scene& scene, const NetworkRunOptions& options) {
  ExperimentSetup setup;
  setup.hand = options.hand;
  setup.bounding = bounding_config(options.parameters, options.hand.spec);
  setup.delay = 1;
  setup.duration = options.duration;
  return run_experiment(scene, setup);
}

constexpr const char* kBad =
    "delay=5,jitter=5,order=free,loss=20,burst=5,reorder=5,duplicate=5,seed=3";

TEST(NetworkRun, WithoutDelayItIsTheDirectLoop) {
  const Scene scene = floor(0.4);
  for (const std::string_view mode : {"none", "contact_frame"}) {
    NetworkRunOptions options = sliding(BoundingSide::client, "delay=0");
    options.parameters.mode = mode;
    const auto network = run_network(scene, options).samples;
    const auto loop = direct(scene, options);
    ASSERT_EQ(network.size(), loop.size());
    double largest = 0.0;
    for (std::size_t n = 0; n < loop.size(); ++n) {
      ASSERT_EQ(network[n].held.force(), loop[n].rendered.force()) << mode << " at " << n;
      ASSERT_EQ(network[n].position, loop[n].position) << mode << " at " << n;
      ASSERT_EQ(network[n].acted, loop[n].held);
      largest = std::max(largest, network[n].acted.norm());
    }
    EXPECT_GT(largest, 1.0);
  }
}

TEST(NetworkRun, ACommandIsAsOldAsTheRoundTrip) {
  struct Case {
    const char* link;
    std::size_t ticks;  // number of ticks until the answer arrives
    double age;         // [s] age of the answer at this time
  };
  // A datagram that is due at a tick arrives before the tick.
  for (const Case& c :
       {Case{"up.delay=7.3,down.delay=5.2", 13, 0.5e-3}, Case{"delay=6", 12, 0.0}}) {
    const auto samples = run_network(floor(), sliding(BoundingSide::client, c.link)).samples;
    for (std::size_t n = 0; n < samples.size(); ++n) {
      // The first sample has the index 1.
      ASSERT_EQ(samples[n].sample_index, n < c.ticks ? 0u : n - c.ticks + 1) << c.link << n;
      if (n >= c.ticks) {
        ASSERT_NEAR(samples[n].command_age, c.age, 1e-12);
      }
    }
  }
}

TEST(NetworkRun, TheIdealIsTheSceneAtTheTruePosition) {
  NetworkRunOptions options = sliding(BoundingSide::both, "delay=20,jitter=3");
  double largest = 0.0;
  for (const NetworkSample& s : run_network(floor(), options).samples) {
    ASSERT_NEAR(s.ideal.force().z(), kStiffness * std::max(0.0, -s.position.z()), 1e-9);
    largest = std::max(largest, s.ideal.force().z());
  }
  EXPECT_GT(largest, 1.0);
}

void expect_same(const NetworkRunResult& a, const NetworkRunResult& b) {
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t n = 0; n < a.samples.size(); ++n) {
    ASSERT_EQ(a.samples[n].held, b.samples[n].held) << n;
    ASSERT_EQ(a.samples[n].position, b.samples[n].position) << n;
    ASSERT_EQ(a.samples[n].sample_index, b.samples[n].sample_index) << n;
  }
  EXPECT_EQ(a.up.bytes, b.up.bytes);
  EXPECT_EQ(a.down.bytes, b.down.bytes);
  EXPECT_EQ(a.true_port.least_margin(), b.true_port.least_margin());
}

TEST(NetworkRun, TheSameSeedGivesTheSameBits) {
  const Scene scene = floor(0.4);
  NetworkRunOptions options = sliding(BoundingSide::both, kBad);
  const auto one = run_network(scene, options);
  expect_same(one, run_network(scene, options));
  options.link.seed = 4;
  const auto other = run_network(scene, options);
  EXPECT_NE(one.up_link.lost, other.up_link.lost);
  EXPECT_NE(one.samples.back().position, other.samples.back().position);
}

std::uint64_t total(const std::array<std::uint64_t, kDropReasons>& drops) {
  return std::accumulate(drops.begin(), drops.end(), std::uint64_t{0});
}
void expect_conserved(const LinkStatistics& s) {
  EXPECT_EQ(s.entered + s.duplicated,
            s.delivered + s.lost + s.queue_dropped + s.overflowed + s.in_flight);
}

TEST(NetworkRun, EveryDatagramIsAccountedFor) {
  for (const char* link : {"delay=0", "delay=25", kBad, "hostile"}) {
    const auto r = run_network(floor(0.4), sliding(BoundingSide::both, link));
    expect_conserved(r.up_link);
    expect_conserved(r.down_link);
    EXPECT_EQ(r.up.datagrams, r.up_link.entered) << link;
    EXPECT_EQ(r.down.datagrams, r.down_link.entered) << link;
    EXPECT_EQ(r.up_link.delivered, r.server.datagrams) << link;
    EXPECT_EQ(r.server.datagrams, r.server.samples.replies + total(r.server.drops)) << link;
    EXPECT_EQ(r.down.datagrams, r.server.samples.replies) << link;
    // Each returned datagram was dropped, was too old, or answered a sample without an answer yet.
    EXPECT_EQ(r.down_link.delivered, r.servo.replies.answered + total(r.client_drops)) << link;
    EXPECT_EQ(r.servo.samples, r.samples.size()) << link;
    EXPECT_GT(r.up.bytes, r.up.datagrams * kHeadersOnTheWire) << link;
    EXPECT_FALSE(r.goodbye);
  }
}

/// The tables must count the bytes on the wire: header, payload, tag, and the headers below.
TEST(NetworkRun, BytesAreThoseOfSealedDatagrams) {
  NetworkRunOptions options = sliding(BoundingSide::client, "delay=0");
  options.parameters.redundancy = 0;
  const auto r = run_network(floor(0.4), options);
  // [bytes] PROTOCOL.md; the first sample has no previous sample
  constexpr std::uint64_t kOneSample = 144, kPrevious = 16;
  EXPECT_EQ(r.up.bytes, r.up.datagrams * (kOneSample + kHeadersOnTheWire) - kPrevious);
}

TEST(NetworkRun, TheClientsBoundHoldsOverAnyLink) {
  for (const char* link : {"delay=0", "delay=50,jitter=20", kBad, "hostile", "transatlantic"})
    for (const BoundingSide side : {BoundingSide::client, BoundingSide::both})
      for (const double friction : {0.0, 0.4}) {
        const auto r = run_network(floor(friction), sliding(side, link));
        EXPECT_EQ(r.measured_port.violations(), 0u) << link << ' ' << name(side);
        EXPECT_GT(r.servo.max_force, 0.1) << link;
      }
}

TEST(NetworkRun, AnUnboundedLoopOverADelayGivesEnergy) {
  NetworkRunOptions options = sliding(BoundingSide::client, "delay=25");
  options.hand.task.path = HandPath::press;
  options.parameters.mode = "none";
  const auto r = run_network(floor(), options);
  EXPECT_GT(r.measured_port.violations(), 100u);
  EXPECT_GT(r.true_port.violations(), 100u);
  EXPECT_LT(r.least_device_margin, -1e-3);
}

TEST(NetworkRun, AServerThatHearsNothingSaysGoodbyeAndTheForceIsGone) {
  NetworkRunOptions options = sliding(BoundingSide::both, "up.loss=100");
  options.silence_timeout = 0.5;
  const auto r = run_network(floor(), options);
  EXPECT_TRUE(r.goodbye);
  EXPECT_EQ(r.server.silent, 1u);
  EXPECT_EQ(r.servo.replies.answered, 0u);
  EXPECT_EQ(r.servo.max_force, 0.0);
  EXPECT_NEAR(static_cast<double>(r.up.datagrams), 501.0, 1.0);  // The client then stops sending.
}

TEST(NetworkRun, ARecordingMovesAsItDid) {
  NetworkRunOptions options = sliding(BoundingSide::both, "delay=10");
  options.parameters.mode = "none";
  options.recording = Recording{{{0.0, {{0, 0, 0.01}, Quaternion::Identity()}},
                                 {0.5, {{0, 0, -0.002}, Quaternion::Identity()}},
                                 {1.5, {{0.05, 0, -0.002}, Quaternion::Identity()}}},
                                false};
  const auto samples = run_network(floor(), options).samples;
  EXPECT_NEAR((samples[250].position - Vec3(0, 0, 0.004)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((samples[1000].position - Vec3(0.025, 0, -0.002)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((samples[1000].velocity - Vec3(0.05, 0, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(samples[1000].held.force().z(), kStiffness * 0.002, 1e-9);
}

NetworkRunOptions taking(BoundingSide side, const char* link) {
  NetworkRunOptions options = sliding(side, link);
  options.taking = TakingTask{.start = {0, 0, 1e-3}, .depth = 8e-3};
  options.duration = 2.5;
  return options;
}

// S(f) = f^2 T / (4 b) is the least storage for a force f. This hand extracts exactly S(f).
TEST(NetworkRun, AHandThatTakesAllTakesWhatWasStoredAndNoMore) {
  for (const char* link : {"delay=0", "delay=10", kBad}) {
    NetworkRunOptions options = taking(BoundingSide::client, link);
    const auto balance = [&](double duration) {
      options.duration = duration;
      const auto r = run_network(floor(), options);
      EXPECT_EQ(r.true_port.violations(), 0u) << link;
      return r.true_port.burned() - r.true_port.delivered().total();
    };
    // [J] before the reversal, with all energy from the hand
    EXPECT_GT(balance(0.39), 1e-2) << link;
    EXPECT_NEAR(balance(0.5), 0.0, 5e-5) << link;  // after the hand extracted all energy
    EXPECT_GE(balance(2.5), 0.0) << link;          // after further movements
  }
}

TEST(NetworkRun, AHandThatTakesAllCatchesADeviceThatIsNotWhatItWasSaidToBe) {
  for (const char* link : {"delay=0", "delay=10", kBad}) {
    NetworkRunOptions options = taking(BoundingSide::client, link);
    options.told = options.hand.spec;
    options.told->damping = 1.05 * 0.5;
    const auto r = run_network(floor(), options);
    EXPECT_GT(r.measured_port.violations(), 0u) << link;
    EXPECT_GT(r.true_port.violations(), 0u) << link;
  }
}

// The bound assumes damping that the light hand does not have, so the hand would oscillate against
// a stiff wall. The account ignores this damping and gives only dissipated energy.
TEST(NetworkRun, ALightHandThatIsCreditedAHeavyOnesDampingIsGivenNoEnergy) {
  const Scene wall = floor(0.0, 40e3);
  NetworkRunOptions options = sliding(BoundingSide::client, "delay=5");
  options.hand.task.path = HandPath::press;
  options.hand.hand = {.mass = 0.02, .damping = 0.5, .stiffness = 300.0};
  EXPECT_EQ(run_network(wall, options).servo.law.account_cut, 0u);
  options.parameters.operator_damping = 5.0;
  const auto told = run_network(wall, options);
  EXPECT_GT(told.servo.law.account_cut, 10u);
  EXPECT_GE(told.least_device_margin, -1e-6);
  EXPECT_GT(told.servo.max_force, 0.1);
}

TEST(NetworkRun, WhereNobodyBoundsAHandTakesAllAndWhereTheServerDoesTheGuardKeepsIt) {
  NetworkRunOptions options = taking(BoundingSide::server, "delay=10");
  const auto cut = run_network(floor(), options);
  EXPECT_GT(cut.servo.law.account_cut, 0u);
  EXPECT_EQ(cut.true_port.violations(), 0u);
  options.parameters.mode = "none";
  EXPECT_LT(run_network(floor(), options).true_port.least_margin(), -0.01);  // [J]
}

TEST(NetworkRun, SaysWhatIsWrong) {
  const Scene scene = floor();
  const auto refused = [&](auto change) {
    NetworkRunOptions options = sliding(BoundingSide::both, "delay=0");
    change(options);
    EXPECT_THROW(run_network(scene, options), std::invalid_argument);
  };
  refused([](auto& o) { o.duration = 1e-4; });
  refused([](auto& o) { o.silence_timeout = 0.0; });
  refused([](auto& o) { o.recording.emplace(); });
  refused([](auto& o) {
    o.recording = Recording{{{0.0, {}}}, false};
    o.taking.emplace();
  });
  refused([](auto& o) {
    o.hand.spec.damping = 0.0;
    o.taking.emplace();
  });
  refused([](auto& o) { o.parameters.servo_period = 1.0; });
  refused([](auto& o) { o.hand.spec.max_force = 0.0; });
  refused([](auto& o) { o.link.up.loss = 0.9, o.link.up.burst = 2.0; });
}

}  // namespace
}  // namespace feltwire::network_run_test
