// Two hands lead one robot at the same time. Each has its own link.

#include <gtest/gtest.h>

#include <string>
#include <variant>

#include "tests/client/simulated_robots/teleoperation_bench.hpp"

namespace feltwire::shared_leaders_test {
namespace {

using test::HandSession;
using test::Teleoperation;
using enum LinkState;

constexpr double kStep = 0.25e-3;  // [m] per sample at the robot's speed limit
// [N] the largest fall of the force per tick: the largest force ends within half the hold time, and
// the hand's own movement adds a part.
constexpr double kFall = 8.9 / 50.0 + 0.05;
constexpr RemoteTrust kNoTrust{.per_contact = 0.0, .power = 0.0};

/// Anna has the hand of the bench, and Ben joins with a second hand.
struct TwoLeaders : Teleoperation {
  static constexpr std::uint64_t kBen = 0x900;

  explicit TwoLeaders(const std::string& link, double anna_share = 1.0, double ben_share = 1.0)
      : Teleoperation(link), ben(kBen, link, 2, kNoTrust) {
    ben.hand.put(Vec3(-0.3, 0.1, 0.2));
    others.push_back(&ben);
    join(kBen, Role::operator_);
    share(kHand, anna_share);
    share(kBen, ben_share);
  }
  void share(std::uint64_t session, double value) {
    const ChangeOutcome made = server->change(LeadChange{session, value}, now);
    ASSERT_TRUE(std::holds_alternative<Changed>(made)) << std::get<control::Refused>(made).reason;
  }
  void engage_both() {
    ben.hand.pressed = false;
    engage();
    ben.hand.pressed = true;
    run(0.3);
    ASSERT_EQ(leads(*this), engaged);
    ASSERT_EQ(leads(ben), engaged);
  }
  /// Moves the targets of both hands by these vectors within the time.
  void move_both(const Vec3& anna, const Vec3& bens, double time) {
    const Vec3 from = ben.hand.meant;
    const int ticks = static_cast<int>(time / kSlice);
    for (int i = 1; i <= ticks; ++i) {
      ben.hand.meant = from + (static_cast<double>(i) / ticks) * bens;
      move(anna / ticks, kSlice);
    }
  }
  static LinkState leads(const HandSession& of) { return of.servo.remote()->remote().state; }
  void expect_no_energy() const {
    EXPECT_LE(made(), 0.0);
    EXPECT_LE(ben.made(), 0.0);
  }

  static constexpr double kSlice = 0.01;  // [s]
  HandSession ben;
};

TEST(SharedLeaders, BothFeelTheForceOnTheRobotWithoutAndWithDelay) {
  for (const char* link : {"delay=0", "delay=50,loss=2,seed=3"}) {
    SCOPED_TRACE(link);
    TwoLeaders bench(link, 3.0, 1.0);
    bench.engage_both();
    bench.move_both(Vec3(0.0, 0.0, -0.045), Vec3(0.0, 0.0, -0.045), 1.0);
    bench.run(2.0);
    ASSERT_GE(bench.force(), 1.0);
    // Each hand's own spring resists the force, so neither moves deep. Both must get equal forces.
    EXPECT_NEAR(bench.force(), bench.ben.force(), 0.1 * bench.force());
    EXPECT_NEAR(bench.force(), bench.robot.force().z(), 0.1 * bench.force());
    bench.expect_no_energy();
    EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
  }
}

TEST(SharedLeaders, AgainstEachOtherTheyMakeNoEnergyAndNoStep) {
  for (const char* link : {"delay=0", "delay=50,jitter=3,loss=5,seed=6"}) {
    SCOPED_TRACE(link);
    TwoLeaders bench(link);
    bench.engage_both();
    bench.move_both(Vec3(0.0, 0.0, -0.03), Vec3(0.0, 0.0, -0.03), 1.0);
    bench.run(0.5);
    bench.fastest_fall = bench.ben.fastest_fall = bench.farthest_step = 0.0;
    // The hands push and pull in opposite directions, along the surface and perpendicular to it.
    for (int i = 0; i < 6; ++i) {
      const double sign = i % 2 == 0 ? 1.0 : -1.0;
      const Vec3 way(0.02 * sign, 0.01, 0.04 * sign);
      bench.move_both(way, -way, 0.4);
      bench.run(0.2);
    }
    EXPECT_EQ(bench.state(), engaged);
    EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
    bench.expect_no_energy();
    // Deep in the wall, the connection of Ben's hand is cut.
    bench.move_both(Vec3(0.0, 0.0, -0.02), Vec3(0.0, 0.0, -0.02), 0.4);
    bench.run(0.5);
    bench.fastest_fall = bench.ben.fastest_fall = 0.0;
    bench.ben.hand_cut = true;
    bench.run(0.3);
    EXPECT_EQ(bench.leads(bench), engaged) << "anna leads on";
    EXPECT_EQ(bench.ben.force(), 0.0);
    EXPECT_LE(bench.ben.fastest_fall, kFall);
    EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
    bench.expect_no_energy();
  }
}

/// The result of Anna's press while Ben uses his switch.
struct Pressed {
  double force, robot_force, depth;  // [N], [N], [m] depth of the target below the wall
};
Pressed press_beside(const char* link, const std::function<void(HandSession&, int)>& ben_does) {
  TwoLeaders bench(link, 1.0, 1.0);
  bench.engage_both();
  bench.ben.hand.pressed = false;
  bench.run(0.3);
  const Vec3 from = bench.hand.meant;
  for (int n = 0; n < 3000; ++n) {
    ben_does(bench.ben, n);
    bench.hand.meant = from - std::min(1.0, n / 1000.0) * Vec3(0.0, 0.0, 0.045);
    bench.tick();
  }
  bench.expect_no_energy();
  EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
  return {bench.force(), bench.robot.force().z(), -bench.commanded.position.z()};
}

/// A hand with a bouncing switch must lead nothing, and must not affect the other hand.
TEST(SharedLeaders, ASwitchThatFlickersDoesNotBlockTheOtherHand) {
  for (const char* link : {"delay=0", "delay=50,loss=2,seed=3"}) {
    SCOPED_TRACE(link);
    const Pressed alone = press_beside(link, [](HandSession&, int) {});
    ASSERT_GE(alone.force, 2.0);
    for (const int period : {2, 3, 10, 40, 120}) {
      const Pressed beside = press_beside(
          link, [&](HandSession& ben, int n) { ben.hand.pressed = n % period >= period / 2; });
      EXPECT_GE(beside.force, 0.5 * alone.force) << period;
      EXPECT_GE(beside.robot_force, 0.5 * alone.robot_force) << period;
    }
  }
}

/// A change of the lead share must not move the target.
TEST(SharedLeaders, AnotherShareMovesNothing) {
  TwoLeaders bench("delay=0");
  bench.engage_both();
  const Vec3 held = bench.commanded.position, from = bench.hand.true_position();
  bench.share(Teleoperation::kHand, 7.0);
  bench.run(0.1);
  EXPECT_EQ(bench.commanded.position, held);
  bench.move(Vec3(0.008, 0.0, 0.0), 0.5);
  bench.run(0.5);
  const double moved = bench.hand.true_position().x() - from.x();
  ASSERT_GT(moved, 0.005);
  EXPECT_NEAR(bench.commanded.position.x() - held.x(), 7.0 / 8.0 * moved, 1e-5);
  const Vec3 then = bench.commanded.position;
  bench.share(Teleoperation::kHand, 0.0);
  bench.run(0.1);
  EXPECT_EQ(bench.leads(bench), disabled) << "she would lead alone, and ben leads";
  EXPECT_EQ(bench.leads(bench.ben), engaged);
  EXPECT_LE((bench.commanded.position - then).norm(), 1e-12);
  bench.ben.hand.pressed = false;
  bench.engage();
  EXPECT_EQ(bench.leads(bench), engaged) << "he let go, and she pressed";
  EXPECT_LE((bench.commanded.position - then).norm(), 1e-12);
}

TEST(SharedLeaders, ATokenGivesTheShareAtTheJoin) {
  Teleoperation bench;
  control::JoinRequest request{"tester", "empty", bench.hand.spec(), bench.parameters,
                               Role::operator_};
  request.lead_share = 0.25;
  const std::uint64_t id = 0x900;
  ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
      bench.server->answer(request, id, test::keys(id), bench.now)));
  const auto listed = std::get<control::SessionDescriptions>(
      bench.server->answer(control::DescribeSessions{"empty", 0}, 0, {}, bench.now));
  ASSERT_EQ(listed.sessions.size(), 3u);
  EXPECT_EQ(listed.sessions[0].lead_share, 0.0);
  EXPECT_EQ(listed.sessions[2].lead_share, 0.25);
  EXPECT_EQ(bench.server->describe()[1].lead_share, std::optional(0.25));
}

TEST(SharedLeaders, WhatHasNoLeadGetsNoShare) {
  Teleoperation bench;
  const auto refused = [&](SceneSessions& sessions, std::uint64_t id, double share) {
    const ChangeOutcome made = sessions.change(LeadChange{id, share}, bench.now);
    const auto* no = std::get_if<control::Refused>(&made);
    return no == nullptr ? std::string() : no->reason;
  };
  EXPECT_EQ(refused(*bench.server, Teleoperation::kHand, 1.0), "");
  for (const double wrong : {-1.0, 0.001, 101.0, std::nan("")})
    EXPECT_EQ(refused(*bench.server, Teleoperation::kHand, wrong),
              "lead share: must be 0 (the hand leads alone), or 0.01 to 100; correct it");
  EXPECT_EQ(refused(*bench.server, Teleoperation::kRobot, 1.0),
            "lead share: session 2 joined as follower and leads no robot; name a hand");
  EXPECT_NE(refused(*bench.server, 0x999, 1.0), "");
  const Scene without = *test::wall_scene();
  SceneSessions sessions(without, std::chrono::seconds(2), 8);
  const std::uint64_t id = 1;
  ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
      sessions.answer(control::JoinRequest{"tester", "wall", bench.hand.spec(), bench.parameters},
                      id, test::keys(id), bench.now)));
  EXPECT_EQ(refused(sessions, id, 1.0),
            "lead share: scene 'wall' has no seat for a robot; give it one with remote "
            "(docs/scenes.md)");
}

}  // namespace
}  // namespace feltwire::shared_leaders_test
