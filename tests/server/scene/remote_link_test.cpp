// Several hands and one robot: who leads it, and that no hand-over moves it.

#include "server/scene/remote_link.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace feltwire::remote_link_test {
namespace {

using enum LinkState;

constexpr double kPeriod = 1e-3;  // [s]
constexpr std::uint32_t kRobot = 9;

struct Hand {
  std::uint32_t number;
  Vec3 at;
  bool pressed = false;
  double work = 0.0;  // [J]
  std::uint64_t index = 0;
};

/// A link whose robot is well and holds what it was told.
struct Bench {
  Bench() {
    link.sit(kRobot);
    state.commanded.position = state.pose.position = Vec3(0.4, 0.1, 0.3);
    say();
  }
  void say() {
    ++state.index;
    link.follow(state, now);
  }
  void send(Hand& hand) {
    now += std::chrono::milliseconds(1);
    say();
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0].index = ++hand.index;
    batch.samples[0].client_time = now;
    batch.samples[0].pose.position = hand.at;
    batch.lead = Lead{.deadman = hand.pressed, .hand_work = hand.work};
    link.lead(hand.number, batch, kPeriod, now);
    target = link.target(now);
    if (target.state == engaged) state.commanded = target.pose;
  }
  void press(Hand& hand) {
    hand.pressed = false;
    send(hand);
    hand.pressed = true;
    send(hand);
  }
  LinkState told(const Hand& hand) const { return link.told(hand.number, now).state; }

  RemoteLink link{RemoteSeat{}};
  RobotState state;
  RobotTarget target;
  Nanoseconds now = std::chrono::seconds(1);
  Hand anna{1, Vec3(1.0, 0.0, 0.0)}, ben{2, Vec3(-3.0, 2.0, 1.0)};
};

TEST(RemoteLink, AHandThatReleasesHandsOverWithoutAStep) {
  Bench bench;
  bench.press(bench.anna);
  bench.anna.at.x() += 1e-4;
  bench.send(bench.anna);
  ASSERT_EQ(bench.told(bench.anna), engaged);
  const Vec3 robot = bench.state.commanded.position;
  EXPECT_NEAR(robot.x(), 0.4001, 1e-12);
  bench.send(bench.ben);  // released
  bench.anna.pressed = false;
  bench.send(bench.anna);
  EXPECT_EQ(bench.told(bench.anna), clutched);
  bench.ben.pressed = true;
  bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.told(bench.anna), disabled);
  EXPECT_EQ(bench.target.pose.position, robot) << "exactly";
  bench.ben.at.y() -= 1e-4;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.pose.position.y(), robot.y() - 1e-4, 1e-12);
}

TEST(RemoteLink, NobodyTakesTheLeadFromAHandThatPresses) {
  Bench bench;
  bench.press(bench.anna);
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.anna), engaged);
  EXPECT_EQ(bench.told(bench.ben), disabled);
  // A switch that was pressed too early, or is taped down, asks nothing later.
  bench.anna.pressed = false;
  bench.send(bench.anna);
  for (int n = 0; n < 50; ++n) bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), disabled);
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  // And back again.
  bench.send(bench.anna);
  bench.ben.pressed = false;
  bench.send(bench.ben);
  bench.anna.pressed = true;
  bench.send(bench.anna);
  EXPECT_EQ(bench.told(bench.anna), engaged);
}

TEST(RemoteLink, AHandThatFellSilentKeepsNobodyWaiting) {
  Bench bench;
  bench.press(bench.anna);
  bench.send(bench.ben);
  bench.ben.pressed = true;
  bench.now += RemoteLink::kSilence;
  bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  bench.send(bench.anna);  // back, and still pressed
  EXPECT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.told(bench.anna), disabled);
}

TEST(RemoteLink, AHandOverPaysNothing) {
  Bench bench;
  bench.press(bench.anna);
  bench.anna.work = 0.25;
  bench.send(bench.anna);
  const double paid = bench.target.hand_work;
  bench.anna.pressed = false;
  bench.send(bench.anna);
  bench.ben.work = 1e6;
  bench.press(bench.ben);
  ASSERT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.target.hand_work, paid);
  bench.ben.work += 0.5;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.hand_work, paid + 0.5, 1e-9);
}

TEST(RemoteLink, AHandThatLeavesMakesRoom) {
  Bench bench;
  bench.press(bench.anna);
  bench.send(bench.ben);
  bench.link.leave(bench.anna.number);
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  std::vector<Hand> crowd;
  for (std::uint32_t n = 0; n < 2 * RemoteLink::kMostWaiting; ++n)
    crowd.push_back({100 + n, Vec3::Zero()});
  for (Hand& hand : crowd) bench.send(hand);
  for (const Hand& hand : crowd) bench.link.leave(hand.number);
  bench.ben.pressed = false;
  bench.send(bench.ben);
  bench.press(bench.anna);
  EXPECT_EQ(bench.told(bench.anna), engaged) << "those that left wait no more";
}

/// Hands that press as they like, from anywhere: whoever begins to lead, the target stays.
TEST(RemoteLink, NoHandOverOfManyMovesTheRobot) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(-10.0, 10.0);
  Bench bench;
  std::vector<Hand> hands;
  for (std::uint32_t n = 1; n <= 6; ++n)
    hands.push_back({n, Vec3(any(random), any(random), any(random))});
  std::uint32_t leads = 0;
  int handed_over = 0;
  for (int n = 0; n < 20000; ++n) {
    Hand& hand = hands[random() % hands.size()];
    if (random() % 8 == 0) hand.pressed = !hand.pressed;
    hand.at += 1e-5 * Vec3(any(random), any(random), any(random));
    const Vec3 before = bench.state.commanded.position;
    bench.send(hand);
    int leading = 0;
    for (const Hand& one : hands) leading += bench.told(one) == engaged ? 1 : 0;
    ASSERT_LE(leading, 1);
    if (bench.told(hand) == engaged && leads != hand.number) {
      ASSERT_EQ(bench.target.pose.position, before) << n;
      leads = hand.number;
      ++handed_over;
    }
  }
  EXPECT_GT(handed_over, 100);
}

}  // namespace
}  // namespace feltwire::remote_link_test
