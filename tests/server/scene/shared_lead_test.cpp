// Several hands lead a robot together. Each hand moves the target by a share of its movement.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/server/scene/teleop_link_bench.hpp"

namespace feltwire::shared_lead_test {
namespace {

using teleop_link_test::Bench;
using teleop_link_test::Hand;
using enum LinkState;

struct SharedBench : Bench {
  explicit SharedBench(const RemoteSeat& seat = {}) : Bench(seat) {
    anna.share = 0.75;
    ben.share = 0.25;
    known_surface = 5;
  }
  Vec3 place() const { return target.pose.position; }
};

TEST(SharedLead, EachMovesTheTargetByItsShareOfThoseThatAreEngaged) {
  SharedBench bench({.scale = 0.5});
  bench.press(bench.anna);
  const Vec3 begin = bench.place();
  bench.anna.at.x() += 1e-4;
  bench.send(bench.anna);
  EXPECT_NEAR(bench.place().x(), begin.x() + 0.5e-4, 1e-15) << "alone she leads alone";
  const Vec3 before = bench.place();
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.anna), engaged);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.place(), before) << "exactly";
  bench.ben.at.y() += 1e-4;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.place().y(), before.y() + 0.25 * 0.5e-4, 1e-15);
  bench.anna.at.y() -= 1e-4;
  bench.send(bench.anna);
  EXPECT_NEAR(bench.place().y(), before.y() - 0.5 * 0.5e-4, 1e-15);
  // Anna releases. Ben then leads alone, from the present position.
  const Vec3 left = bench.place();
  bench.anna.pressed = false;
  bench.send(bench.anna);
  EXPECT_EQ(bench.told(bench.anna), clutched);
  EXPECT_EQ(bench.target.state, engaged);
  EXPECT_EQ(bench.place(), left);
  bench.ben.at.z() += 1e-4;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.place().z(), left.z() + 0.5e-4, 1e-15);
}

TEST(SharedLead, EveryHandFeelsTheForceOnTheRobotAndPaysItsPart) {
  SharedBench bench({.scale = 2.0});
  bench.press(bench.anna);
  bench.press(bench.ben);
  // A surface is 3 mm above the target. A spring of 600 N/m presses with 1.8 N.
  bench.state.contact = {.surface = 5,
                         .touching = true,
                         .point = bench.place() + Vec3(0, 0, 3e-3),
                         .normal = Vec3::UnitZ(),
                         .stiffness = 600.0};
  bench.say();
  for (const Hand* hand : {&bench.anna, &bench.ben}) {
    const RemoteContact seen = bench.link.reply_for(hand->number, bench.now).contact;
    EXPECT_NEAR(seen.stiffness * (seen.point - hand->at).z(), 1.8, 1e-9);
    EXPECT_NEAR(seen.stiffness, 600.0 * 2.0 * hand->share, 1e-9) << "that its own way meets";
  }
  // Ben moves the target 0.1 mm deeper, and Anna must feel the force.
  bench.ben.at.z() -= 0.1e-3 / (2.0 * 0.25);
  bench.send(bench.ben);
  const RemoteContact seen = bench.link.reply_for(bench.anna.number, bench.now).contact;
  EXPECT_NEAR(seen.stiffness * (seen.point - bench.anna.at).z(), 1.86, 1e-9);
  // The work of a force on the target must equal the sum of the hands' energies.
  const double before = bench.target.hand_work;
  bench.anna.work += 0.1;
  bench.send(bench.anna);
  bench.ben.work += 0.3;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.hand_work - before, 2.0 * (0.75 * 0.1 + 0.25 * 0.3), 1e-12);
}

TEST(SharedLead, TheLargestShareTurnsTheRobot) {
  SharedBench bench;
  bench.press(bench.anna);
  bench.press(bench.ben);
  const Quaternion before = bench.target.pose.orientation;
  bench.ben.turn = Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitX()));
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.pose.orientation.angularDistance(before), 0.0, 1e-12);
  bench.anna.turn = Quaternion(Eigen::AngleAxisd(0.2, Vec3::UnitZ()));
  bench.send(bench.anna);
  EXPECT_NEAR(bench.target.pose.orientation.angularDistance(before), 0.2, 1e-7);
  // With the larger share, Ben must rotate the robot from its present orientation.
  const Quaternion turned = bench.target.pose.orientation;
  bench.ben.share = 3.0;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.pose.orientation.angularDistance(turned), 0.0, 1e-7);
  bench.ben.turn = Quaternion(Eigen::AngleAxisd(0.4, Vec3::UnitX()));
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.pose.orientation.angularDistance(turned), 0.1, 1e-7);
}

TEST(SharedLead, WhoLeadsAloneWaitsForAllAndIsNotJoined) {
  SharedBench bench;
  Hand carl{.number = 3, .at = Vec3::Zero()};
  bench.press(bench.anna);
  bench.press(bench.ben);
  bench.press(carl);
  EXPECT_EQ(bench.told(carl), disabled);
  bench.anna.pressed = false;
  bench.send(bench.anna);
  bench.press(carl);
  EXPECT_EQ(bench.told(carl), disabled) << "one still presses";
  bench.ben.pressed = false;
  bench.send(bench.ben);
  bench.press(carl);
  EXPECT_EQ(bench.told(carl), engaged);
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), disabled);
  EXPECT_EQ(bench.told(carl), engaged);
}

TEST(SharedLead, AHandThatFallsSilentOrJumpsHoldsItselfAlone) {
  SharedBench bench;
  bench.press(bench.anna);
  bench.press(bench.ben);
  const Vec3 before = bench.place();
  for (int n = 0; n < 200; ++n) bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.anna), hold);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.place(), before);
  bench.ben.at.x() += 1.0;
  bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), hold);
  EXPECT_EQ(bench.target.state, hold);
}

/// Ben's switch bounces at every sample. Soon Ben must lead nothing, and Anna must lead alone.
TEST(SharedLead, ASwitchThatFlickersTakesNothingFromTheOther) {
  SharedBench bench;
  bench.ben.share = 3.0;
  bench.press(bench.anna);
  const auto flicker = [&](int samples) {
    for (int n = 0; n < samples; ++n) {
      bench.ben.pressed = !bench.ben.pressed;
      bench.send(bench.ben);
      bench.send(bench.anna);
    }
  };
  flicker(20);
  const Vec3 before = bench.place();
  for (int n = 0; n < 100; ++n) {
    bench.anna.at.x() += 1e-5;
    flicker(1);
    EXPECT_NE(bench.told(bench.ben), engaged) << n;
  }
  EXPECT_EQ(bench.told(bench.anna), engaged);
  EXPECT_NEAR(bench.place().x() - before.x(), 1e-3, 1e-12) << "she leads alone";
  EXPECT_TRUE(bench.link.reply_for(bench.anna.number, bench.now).meets_surfaces);
  // A switch that is pressed long enough must count again.
  bench.ben.pressed = true;
  for (int n = 0; n < 600; ++n) {
    bench.send(bench.ben);
    bench.send(bench.anna);
  }
  EXPECT_EQ(bench.told(bench.ben), engaged);
}

/// A single leader must hand over to a pressing hand, even if the leader's own switch bounces.
TEST(SharedLead, ASwitchThatFlickersKeepsTheLeadFromNobody) {
  SharedBench bench;
  bench.anna.share = bench.ben.share = 0.0;
  bench.press(bench.anna);
  for (int n = 0; n < 20; ++n) {
    bench.anna.pressed = !bench.anna.pressed;
    bench.send(bench.anna);
    bench.send(bench.ben);  // Ben waits with a released switch.
  }
  bench.anna.pressed = true;
  bench.send(bench.anna);
  bench.ben.pressed = true;
  bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.told(bench.anna), disabled);
}

/// Hands press, release, leave, move and change shares at random. The target must move only by a
/// hand's movement times its share.
TEST(SharedLead, NothingButAMovementMovesTheTarget) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0), share(0.05, 1.0);
  SharedBench bench;
  std::vector<Hand> hands;
  for (std::uint32_t n = 1; n <= 6; ++n)
    hands.push_back(
        {.number = n, .at = Vec3(any(random), any(random), any(random)), .share = share(random)});
  int changes = 0, together = 0;
  const auto engaged_now = [&] {
    std::vector<std::uint32_t> numbers;
    for (const Hand& hand : hands)
      if (bench.told(hand) == engaged) numbers.push_back(hand.number);
    return numbers;
  };
  for (int n = 0; n < 20000; ++n) {
    Hand& hand = hands[random() % hands.size()];
    const std::vector<std::uint32_t> led = engaged_now();
    const Vec3 before = bench.state.commanded.position;
    Vec3 way = Vec3::Zero();
    const auto what = random() % 12;
    if (what == 0) hand.pressed = !hand.pressed;
    if (what == 1) hand.share = share(random);
    if (what == 2 && random() % 20 == 0) bench.link.leave(hand.number);
    if (what > 2) way = 1e-5 * Vec3(any(random), any(random), any(random));
    hand.at += way;
    bench.send(hand);
    const bool same = led == engaged_now();
    changes += same ? 0 : 1;
    if (led.empty() && bench.target.state != engaged) continue;
    if (!same || what <= 2) {
      // Another hand may have become silent after this move.
      ASSERT_LE((bench.place() - before).norm(), way.norm() + 1e-15) << n;
      continue;
    }
    double sum = 0.0, own = 0.0;
    for (const Hand& one : hands)
      if (bench.told(one) == engaged) {
        sum += one.share;
        own += one.number == hand.number ? one.share : 0.0;
      }
    together += led.size() > 1 ? 1 : 0;
    if (sum > 0.0) {
      ASSERT_LE((bench.place() - before - own / sum * way).norm(), 1e-12) << n;
    }
  }
  EXPECT_GT(changes, 200);
  EXPECT_GT(together, 1000);  // Some switches bounce.
}

}  // namespace
}  // namespace feltwire::shared_lead_test
