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
  Vec3 offset = Vec3::Zero();  // [m]
  Quaternion turn = Quaternion::Identity();
};

/// A link whose robot is well and holds what it was told.
struct Bench {
  explicit Bench(const RemoteSeat& seat = {}, const Workspace& own = {}) : link(seat) {
    link.sit(kRobot, own);
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
    batch.samples[0].pose = {hand.at, hand.turn};
    batch.lead = Lead{.deadman = hand.pressed, .offset = hand.offset, .hand_work = hand.work};
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

  RemoteLink link;
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

RemoteSeat aligned_seat(double gate) {
  RemoteSeat seat;
  seat.aligned = Alignment{Quaternion(Eigen::AngleAxisd(1.0, Vec3(1.0, 2.0, 2.0) / 3.0)), gate};
  return seat;
}

TEST(RemoteLink, AHandTurnsToTheRobotBeforeItEngages) {
  const RemoteSeat seat = aligned_seat(0.2);
  Bench bench(seat);
  const Quaternion robot = bench.state.commanded.orientation =
      Quaternion(Eigen::AngleAxisd(0.7, Vec3::UnitY()));
  const Quaternion there = robot * seat.aligned->offset.conjugate();  // where it is aligned
  Hand& anna = bench.anna;
  const auto missing = [&] { return bench.link.told(anna.number, bench.now).turn; };
  anna.turn = turned(there, Vec3(0.0, 0.0, 0.5));
  bench.press(anna);
  EXPECT_EQ(bench.told(anna), aligning);
  EXPECT_EQ(bench.link.state(), aligning);
  ASSERT_TRUE(missing());
  EXPECT_NEAR((*missing() + Vec3(0.0, 0.0, 0.5)).norm(), 0.0, 1e-9) << "back by 0.5 rad";
  anna.turn = turned(there, Vec3(0.0, 0.0, 0.19));
  bench.send(anna);
  EXPECT_EQ(bench.told(anna), aligning) << "the switch was pressed outside of the gate";
  anna.pressed = false;
  bench.send(anna);
  EXPECT_EQ(bench.told(anna), ready);
  anna.pressed = true;
  bench.send(anna);
  ASSERT_EQ(bench.told(anna), engaged);
  EXPECT_FALSE(missing());
  EXPECT_LE(rotation_between(bench.target.pose.orientation, robot).norm(), 1e-12);
  EXPECT_EQ(bench.target.pose.position, Vec3(0.4, 0.1, 0.3)) << "exactly";
  // While it turns, it goes to the orientation that it means.
  for (int i = 0; i < 500; ++i) {
    anna.turn = turned(anna.turn, Vec3(0.0, 1e-3, 0.0));
    bench.send(anna);
  }
  EXPECT_LE(
      rotation_between(bench.target.pose.orientation, anna.turn * seat.aligned->offset).norm(),
      1e-9);
  // It lets go, turns away, and has to come back.
  anna.pressed = false;
  bench.send(anna);
  EXPECT_EQ(bench.told(anna), clutched);
  anna.turn = turned(anna.turn, Vec3(0.3, 0.0, 0.0));
  bench.press(anna);
  EXPECT_EQ(bench.told(anna), aligning);
}

/// Hands that turn and press as they like: none engages outside of the gate, no target turns by
/// more than 1.5 times what the hand turned, and none steps at an engagement.
TEST(RemoteLink, NoEngagementOfAnAlignedHandTurnsTheRobot) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const RemoteSeat seat = aligned_seat(0.3);
  Bench bench(seat);
  int engagements = 0, refused = 0;
  for (int n = 0; n < 30000; ++n) {
    Hand& hand = random() % 2 == 0 ? bench.anna : bench.ben;
    if (random() % 16 == 0) hand.pressed = !hand.pressed;
    const double step = random() % 500 == 0 ? 0.5 : 2e-3;
    const Quaternion had = hand.turn;
    hand.turn = turned(had, step * Vec3(any(random), any(random), any(random)));
    const LinkState before = bench.told(hand);
    const Quaternion robot = bench.state.commanded.orientation;
    bench.send(hand);
    const double moved = rotation_between(robot, bench.state.commanded.orientation).norm();
    const bool leads = bench.told(hand) == engaged;
    refused += bench.told(hand) == aligning ? 1 : 0;
    if (leads && before != engaged) {
      ++engagements;
      ASSERT_LE(moved, 1e-12);
      ASSERT_LE(seat.aligned->missing(hand.turn, robot).norm(), seat.aligned->gate);
    }
    ASSERT_LE(moved, leads ? 1.5 * rotation_between(had, hand.turn).norm() + 1e-12 : 0.0);
    if (n % 1000 == 0)  // so that it comes back
      hand.turn = bench.state.commanded.orientation * seat.aligned->offset.conjugate();
  }
  EXPECT_GT(engagements, 100);
  EXPECT_GT(refused, 100);
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

RemoteSeat walled_seat(double scale = 1.0) {
  RemoteSeat seat;
  seat.scale = scale;
  seat.speed = 10.0;
  seat.workspace.add_box(Vec3(0.3, 0.0, 0.2), Vec3(0.5, 0.2, 0.4));
  return seat;
}

TEST(RemoteLink, TheTargetStaysInTheWorkspaceForAnyHand) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> step(0.0, 2e-3);
  for (const double scale : {0.3, 1.0, 4.0}) {
    Bench bench(walled_seat(scale));
    bench.press(bench.anna);
    for (int i = 0; i < 5000; ++i) {
      bench.anna.at += Vec3(step(random), step(random), step(random));
      // One that takes no heed of walls, and one that lies of its offset.
      if (i % 1000 == 500) bench.anna.offset = 100.0 * Vec3::Random();
      bench.send(bench.anna);
      ASSERT_EQ(bench.target.state, engaged);
      const Vec3& at = bench.target.pose.position;
      ASSERT_TRUE((at.array() >= Eigen::Array3d(0.3, 0.0, 0.2) - 1e-9).all() &&
                  (at.array() <= Eigen::Array3d(0.5, 0.2, 0.4) + 1e-9).all())
          << at.transpose();
    }
  }
}

TEST(RemoteLink, AHandThatComesBackFromAWallMovesTheRobotAtOnce) {
  Bench bench(walled_seat());
  bench.press(bench.anna);
  for (int i = 0; i < 300; ++i) {
    bench.anna.at.x() += 1e-3;
    bench.send(bench.anna);
  }
  EXPECT_NEAR(bench.target.pose.position.x(), 0.5, 1e-12);
  for (int i = 1; i <= 20; ++i) {
    bench.anna.at.x() -= 1e-3;
    bench.send(bench.anna);
    ASSERT_NEAR(bench.target.pose.position.x(), 0.5 - 1e-3 * i, 1e-12);
  }
}

TEST(RemoteLink, TellsTheNearestWallsWhereTheHandMeetsThem) {
  Bench bench(walled_seat(2.0));
  bench.send(bench.anna);
  EXPECT_EQ(bench.link.told(bench.anna.number, bench.now).wall_count, 0) << "only while engaged";
  bench.press(bench.anna);
  const Vec3 began = bench.anna.at;
  for (int i = 0; i < 10; ++i) {
    bench.anna.at += Vec3(3e-3, -2e-3, 1e-3);  // of the robot: 60, -40 and 20 mm in all
    bench.send(bench.anna);
  }
  const Remote told = bench.link.told(bench.anna.number, bench.now);
  ASSERT_EQ(told.wall_count, 3);
  // The robot is at (0.46, 0.06, 0.32) in the box: 40 mm from x = 0.5, 60 from y = 0, 80 from z =
  // 0.4.
  const Vec3 normals[] = {-Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitZ()};
  const double away[] = {0.02, 0.03, 0.04};  // of the hand
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(told.walls[i].wall.normal, normals[i]);
    EXPECT_NEAR(told.walls[i].wall.clearance(bench.anna.at), away[i], 1e-12);
    EXPECT_EQ(told.walls[i].stiffness, 1000.0);
    EXPECT_EQ(told.walls[i].depth, 5e-3);
  }
  EXPECT_NEAR(told.walls[0].wall.clearance(began), 0.05, 1e-12);
}

TEST(RemoteLink, ATargetThatIsOutsideComesBackAndIsNotPulled) {
  Bench bench(walled_seat());
  bench.state.commanded.position.x() = 0.6;
  bench.press(bench.anna);
  EXPECT_EQ(bench.target.pose.position, Vec3(0.6, 0.1, 0.3)) << "exactly: nothing is pulled in";
  const auto move = [&](double x) {
    bench.anna.at.x() += x;
    bench.send(bench.anna);
    return bench.target.pose.position.x();
  };
  EXPECT_NEAR(move(0.01), 0.6, 1e-12) << "no farther out";
  EXPECT_NEAR(move(-0.02), 0.58, 1e-12);
  EXPECT_NEAR(move(0.01), 0.58, 1e-12) << "nor out again";
  for (int i = 0; i < 10; ++i) move(-0.01);
  EXPECT_NEAR(move(0.0), 0.48, 1e-12);
  for (int i = 0; i < 10; ++i) move(0.01);
  EXPECT_NEAR(move(0.0), 0.5, 1e-12) << "now the wall is where it is meant";
}

TEST(RemoteLink, LockedAxesKeepTheValueOfEachEngagement) {
  RemoteSeat seat;
  seat.speed = 10.0;
  seat.workspace.locked = {false, true, false};
  Workspace own;
  own.turning_locked = true;  // the robot's, beside the seat's
  Bench bench(seat, own);
  bench.press(bench.anna);
  for (int i = 0; i < 50; ++i) {
    bench.anna.at += Vec3(1e-3, 2e-3, -1e-3);
    bench.anna.turn = Quaternion(Eigen::AngleAxisd(0.01 * i, Vec3::UnitX()));
    bench.send(bench.anna);
    ASSERT_EQ(bench.target.pose.position.y(), 0.1) << "exactly";
    ASSERT_EQ(bench.target.pose.orientation.coeffs(), Quaternion::Identity().coeffs());
  }
  EXPECT_NEAR(bench.target.pose.position.x(), 0.45, 1e-12);
  EXPECT_NEAR(bench.target.pose.position.z(), 0.25, 1e-12);
  bench.state.commanded.position.y() = 0.15;  // somebody has moved the robot
  bench.press(bench.anna);
  bench.anna.at.y() += 0.01;
  bench.send(bench.anna);
  EXPECT_EQ(bench.target.pose.position.y(), 0.15);
}

/// All surfaces are told where the hand meets them, as far as its axes are free.
TEST(RemoteLink, TellsTheSurfacesBesideTheContact) {
  RemoteSeat seat;
  seat.scale = 2.0;
  seat.workspace.locked = {false, true, false};
  Bench bench(seat);
  bench.press(bench.anna);
  const Vec3 robot = bench.state.commanded.position;
  const auto surface = [&](std::uint32_t number, const Vec3& normal) {
    return RemoteContact{
        .surface = number, .point = robot - 0.01 * normal, .normal = normal, .stiffness = 700.0};
  };
  OtherSurfaces& others = bench.state.others;
  others.count = 2;
  bench.state.contact = surface(3, Vec3::UnitZ());
  others.surfaces = {surface(1, Vec3::UnitX()), surface(2, Vec3::UnitY())};
  bench.say();
  const Remote told = bench.link.told(bench.anna.number, bench.now);
  EXPECT_EQ(told.contact.surface, 3u);
  ASSERT_EQ(told.others.count, 1) << "nothing is told along a locked axis";
  const RemoteContact& other = told.others.surfaces[0];
  EXPECT_EQ(other.surface, 1u);
  EXPECT_NEAR((bench.anna.at - other.point).dot(other.normal), 0.005, 1e-12);
  EXPECT_EQ(other.stiffness, 1400.0);
  bench.anna.pressed = false;
  bench.send(bench.anna);
  EXPECT_EQ(bench.link.told(bench.anna.number, bench.now).others.count, 0) << "not engaged";
}

TEST(RemoteLink, TheTighterOfTwoWorkspacesHolds) {
  Workspace own;
  own.add_box(Vec3(0.0, 0.05, 0.0), Vec3(0.42, 1.0, 1.0));
  Bench bench(walled_seat(), own);
  bench.press(bench.anna);
  for (int i = 0; i < 200; ++i) {
    bench.anna.at += Vec3(1e-3, -1e-3, 1e-3);
    bench.send(bench.anna);
  }
  EXPECT_LE((bench.target.pose.position - Vec3(0.42, 0.05, 0.4)).norm(), 1e-9);
}

}  // namespace
}  // namespace feltwire::remote_link_test
