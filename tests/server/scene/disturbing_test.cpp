// A hand that breaks the simulation repeatedly must be found and ended. The other hands must stay.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocol/net/clock.hpp"
#include "server/app/server.hpp"
#include "server/app/summary.hpp"
#include "tests/core/moving.hpp"
#include "tests/server/moving_bench.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::disturbing_test {
namespace {

using namespace std::chrono_literals;
using test::body;
using test::kLeft;
using test::kRight;
using test::kThird;
using test::kWeightless;
using test::moving;
using test::MovingBench;
using test::object;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Returns a device that claims ten kilonewtons, more than any real device.
DeviceSpec giant() {
  DeviceSpec spec = test::device();
  spec.max_force = spec.continuous_force = 1e4;
  return spec;
}

/// Returns two separate boxes on a table.
Scene boxes() {
  const Material wood{.stiffness = 1e5, .static_friction = 0.5, .dynamic_friction = 0.4};
  return moving(
      {object("table", Plane{}, wood), object("one", Box{Vec3::Constant(0.02)}, wood, {0, 0, 0.02}),
       object("other", Box{Vec3::Constant(0.02)}, wood, {0, 0.5, 0.02})},
      {-1, 0, 1}, {body("one", 0.05, {0, 0, 0.02}), body("other", 0.5, {0, 0.5, 0.02})});
}

struct Course {
  std::vector<EndedSession> ended;
  std::uint64_t resets = 0;
  int ticks_after = 0;  // since the last reset
  std::vector<GoodbyeReason> goodbyes;
};

/// Returns the position of the strong hand at this time. The hand moves a third of a metre through
/// the first box, and returns above the box.
Vec3 stab(std::int64_t milliseconds) {
  const auto phase = milliseconds % 320;
  if (phase < 20) return {0.3, 0, 0.02};
  if (phase < 100) return {0.3, 0, 0.5};
  if (phase < 200) return {-0.025, 0, 0.5};
  return {-0.025, 0, 0.02};
}

/// The strong hand hits the first box. Another hand rests on this box, and a third hand on the
/// other box.
Course play(MovingBench& bench, bool giant_is_there) {
  Course course;
  bench.join(kLeft);
  bench.join(kRight);
  if (giant_is_there) bench.join(kThird, {}, giant());
  for (int n = 0; n < 8000; ++n) {
    const auto there = [&](std::uint64_t id) { return bench.sessions.find(id) != nullptr; };
    if (there(kLeft)) bench.hand(kLeft, {0, 0, 0.03999});
    if (there(kRight)) bench.hand(kRight, {0, 0.5, 0.03999});
    if (there(kThird)) bench.hand(kThird, stab(n + 200));
    const std::uint64_t before = bench.world().counters().resets;
    bench.advance();
    if (bench.world().counters().resets > before) course.ticks_after = 0;
    ++course.ticks_after;
    if (n % 100 != 99) continue;
    for (const auto& goodbye : bench.sessions.expire(bench.now)) {
      GoodbyeReason reason = GoodbyeReason::leaving;
      EXPECT_EQ(decode(test::opened(goodbye.datagram, test::Way::down), reason), DropReason::none);
      course.goodbyes.push_back(reason);
    }
  }
  course.ended = bench.sessions.ended();
  course.resets = bench.world().counters().resets;
  return course;
}

TEST(Disturbing, WhoBreaksWhatMovesEndsAndNobodyElse) {
  const Scene scene = boxes();
  MovingBench bench(scene);
  const Course course = play(bench, true);
  EXPECT_GT(course.resets, SessionLimits::kResets);
  EXPECT_THAT(course.ended, ElementsAre(EndedSession{kThird, SessionEnd::disturbing}));
  EXPECT_THAT(course.goodbyes, ElementsAre(GoodbyeReason::disturbing));
  EXPECT_EQ(bench.sessions.counters().disturbing, 1u);
  EXPECT_EQ(bench.sessions.counters().evicted, 0u);
  // The simulation must stay stable afterwards.
  EXPECT_GT(course.ticks_after, 4000);
  EXPECT_NE(bench.sessions.find(kLeft), nullptr);
  EXPECT_NE(bench.sessions.find(kRight), nullptr);
}

TEST(Disturbing, WithoutHimNothingBreaks) {
  const Scene scene = boxes();
  MovingBench bench(scene);
  EXPECT_EQ(play(bench, false).resets, 0u);
}

/// The server must tolerate occasional resets. Only more than half a reset a second may end a
/// session.
TEST(Disturbing, NowAndThenIsForgiven) {
  const Scene scene = test::explosive();
  MovingBench bench(scene);
  bench.join(kLeft);
  std::uint64_t resets = 0;
  for (int n = 0; n < 60'000; ++n) {
    // The hand touches every three seconds until the simulation breaks.
    const bool touches = bench.world().counters().resets <= resets && n % 3000 > 2500;
    if (n % 3000 == 0) resets = bench.world().counters().resets;
    bench.hand(kLeft, touches ? Vec3(0, 0, 0.1705) : Vec3(0, 0, 0.5));
    bench.advance();
    if (n % 100 == 0) bench.sessions.expire(bench.now);
    ASSERT_NE(bench.sessions.find(kLeft), nullptr) << n;
  }
  EXPECT_GE(bench.world().counters().resets, 15u);
}

/// A scene may break by itself. No hand is the cause, and all hands must stay.
TEST(Disturbing, ASceneThatBreaksByItselfBlamesNobody) {
  // The ball is too fast after a tenth of a second.
  const Scene scene = moving({object("ball", Sphere{0.05}, {.stiffness = 1000})}, {0},
                             {body("ball", 1.0)}, {.gravity = {0, 0, -1e3}});
  MovingBench bench(scene);
  bench.join(kLeft);
  for (int n = 0; n < 2000; ++n) {
    bench.hand(kLeft, {1, 0, 0});
    bench.advance();
    if (n % 100 == 0) bench.sessions.expire(bench.now);
  }
  EXPECT_GT(bench.world().counters().resets, 15u);
  EXPECT_NE(bench.sessions.find(kLeft), nullptr);
}

/// The log and summary of a complete server must report the hand. The client must stay out for some
/// time.
TEST(Disturbing, IsCountedAndKeptOut) {
  std::vector<Scene> scenes;
  scenes.push_back(boxes());
  Server server(test::any_port(), std::move(scenes), test::security());
  test::ControlClient control(server.control_port());
  SessionParameters parameters;
  parameters.servo_period = 1e-5;  // [s] allows many samples
  control::JoinRequest request = test::join_request(parameters);
  request.scene = "moving";
  request.device = giant();
  const auto joined = control.join(request);
  test::RawSocket socket(SOCK_DGRAM, joined.udp_port);
  test::SealedEncoder encoder(test::Way::up, joined.keys);
  std::uint64_t n = 0;
  test::eventually("an end", [&] {
    ++n;
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0].index = n;
    batch.samples[0].client_time = static_cast<std::int64_t>(n) * 1ms;
    batch.samples[0].pose.position = stab(monotonic_now() / 1ms);
    socket.send(encoder.samples(joined.accepted.session, n, batch));
    socket.receive();
    return server.summary()[0].counters.disturbing == 1;
  });
  EXPECT_THAT(summary_json(server.summary(), server.control_summary()),
              HasSubstr("\"disturbing\": 1"));
  EXPECT_THAT(text(server.summary()), HasSubstr("disturbing 1"));
  const auto refused = control.ask<control::Refused>(request);
  EXPECT_EQ(refused.code, control::RefusalCode::too_many);
  EXPECT_THAT(refused.reason, HasSubstr("broke the simulation of scene 'moving'"));
  request.role = Role::observer;
  control.join(request);
}

}  // namespace
}  // namespace feltwire::disturbing_test
