// A hand leads the arm in the server's own world (scenes/arm/workcell.json) over sealed datagrams
// and an emulated link. The hand presses on the mat and lifts the box. No other hand may move the
// arm.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/scene_file/load_scene.hpp"
#include "tests/client/simulated_robots/teleoperation_bench.hpp"

namespace feltwire::world_arm_test {
namespace {

using enum LinkState;
using ::testing::HasSubstr;

constexpr double kTable = 0.3;  // [m] height of the table, scenes/arm/table.xml
constexpr double kMat = 0.3;    // [m] height of the mat, scenes/arm/workcell.xml
// The arm's spring and the table's spring, in series.
constexpr double kSeries = 1000.0 * 5000.0 / 6000.0;  // [N/m]
constexpr double kBoxHalf = 0.02;                     // [m]
constexpr double kOpen = 0.08;                        // [m] opening of the gripper
const Vec3 kOverBox(0.45, 0.0, 0.36);                 // [m] position of the tool

Scene arm_scene() { return load_scene(FELTWIRE_SOURCE_DIR "/scenes/arm/workcell.json"); }
/// Returns a scene with a table of 5 kN/m at a height of 0.3 m.
Scene table_scene() {
  return parse_scene(R"({ "name": "arm", "materials": [{ "name": "steel", "stiffness": 2000 }],
    "mjcf": { "file": "table.xml", "material": "steel" }, "remote": { "arm": {} } })",
                     FELTWIRE_SOURCE_DIR "/scenes/arm/table.json");
}

struct Bench : test::HandSession {
  static constexpr std::uint64_t kHand = 0x700;
  static constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);

  explicit Bench(const std::string& link = "delay=0", Scene of_server = arm_scene())
      : HandSession(kHand, link, 0, {.per_contact = 0.0, .power = 0.0}, {""}),
        scene(std::move(of_server)),
        server(std::make_unique<SceneSessions>(scene, std::chrono::seconds(2), 8)) {
    hand.put(Vec3(0.1, -0.2, 0.3));
    join(*this, kHand);
  }
  void join(HandSession& joining, std::uint64_t id) {
    const control::Message answer = ask_to_join(joining, id, Role::operator_);
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(answer));
  }
  control::Message ask_to_join(HandSession& joining, std::uint64_t id, Role role) {
    return server->answer(
        control::JoinRequest{"tester", "arm", joining.hand.spec(), joining.parameters, role}, id,
        test::keys(id), now);
  }
  void tick() {
    now += kPeriod;
    server->tick(now);
    reach(*server, now, room);
    for (HandSession* other : others) other->reach(*server, now, room);
    hear(now);
    for (HandSession* other : others) other->hear(now);
    if (names_another)
      name_another();
    else if (!silent)
      sample(now);
    for (HandSession* other : others) other->sample(now);
    const SeenRobot robot = arm();
    largest_force = std::max(largest_force, robot.force.value_or(Vec3::Zero()).norm());
    farthest_step = std::max(farthest_step, (robot.target.position - target_.position).norm());
    target_ = robot.target;
  }
  void run(double time) {
    for (double t = 0.0; t < time; t += 1e-3) tick();
  }
  void move(const Vec3& way, double time) {
    const Vec3 from = hand.meant;
    const int ticks = static_cast<int>(time / 1e-3);
    for (int i = 1; i <= ticks; ++i) {
      const double s = static_cast<double>(i) / ticks;
      hand.meant = from + (s * s * (3.0 - 2.0 * s)) * way;
      tick();
    }
  }
  void engage() {
    hand.pressed = false;
    run(0.3);
    hand.pressed = true;
    target_ = arm().target;
    farthest_step = 0.0;
    run(0.3);
  }
  /// Engages and moves the tool above the box.
  void go_over_box() {
    engage();
    ASSERT_EQ(server->link_state(0), engaged);
    move(kOverBox - arm().pose.position, 3.0);
    run(0.5);
    ASSERT_NEAR((arm().pose.position - kOverBox).norm(), 0.0, 0.01);
  }

  SeenRobot arm() const {
    Picture picture;
    server->draw(picture, now);
    return picture.robots.empty() ? SeenRobot{} : picture.robots.front();
  }
  const Object& object(const std::string& name) const {
    return *std::ranges::find(server->world()->objects(), name, &Object::name);
  }
  double box() const { return object("box").pose.position.z(); }  // [m] height of the box

  Scene scene;
  std::unique_ptr<SceneSessions> server;
  std::vector<HandSession*> others;
  bool silent = false;         // The hand sends nothing.
  bool names_another = false;  // The samples name the second robot, independently of the servo.
  Nanoseconds now = std::chrono::seconds(100);
  double largest_force = 0.0;  // [N] largest force on the arm's tool
  double farthest_step = 0.0;  // [m] largest movement of the arm's target per tick
  DatagramBuffer room;

 private:
  void name_another() {
    const Sample* sample = servo.tick(hand, now);
    Lead lead = *servo.lead();
    lead.seat = 1;
    hand_link.up.enter(hand_datagrams.pack(*sample, {}, lead), now);
  }
  Pose target_;
};

TEST(WorldArm, BeginsAtHomeAndItsFirstStepIsZero) {
  Bench bench;
  bench.run(0.2);
  const SeenRobot begun = bench.arm();
  EXPECT_NEAR((begun.pose.position - Vec3(0.306891, 0.0, 0.486)).norm(), 0.0, 0.02);
  EXPECT_EQ(bench.server->link_state(0), ready);
  bench.engage();
  EXPECT_EQ(bench.server->link_state(0), engaged);
  EXPECT_LT(bench.farthest_step, 1e-6) << "[m]: the hand stands still";
  bench.run(0.5);
  EXPECT_LT((bench.arm().pose.position - begun.pose.position).norm(), 1e-3);
}

TEST(WorldArm, PressesOverADelayAndLoss) {
  for (const char* link : {"delay=0", "delay=25,loss=2,seed=1"}) {
    SCOPED_TRACE(link);
    Bench bench(link, table_scene());
    bench.engage();
    bench.move(Vec3(0.45, 0.0, kTable + 0.01) - bench.arm().pose.position, 3.0);
    bench.largest_force = 0.0;
    bench.move(Vec3(0.0, 0.0, -0.04), 3.0);
    bench.run(1.0);
    const SeenRobot pressed = bench.arm();
    const double arm = pressed.force.value_or(Vec3::Zero()).z(), hand = bench.force();
    Picture picture;
    bench.server->draw(picture, bench.now);
    EXPECT_EQ(picture.hands.front().states, bit(HandState::moves_robot)) << "not free space";
    EXPECT_EQ(bench.server->link_state(0), engaged);
    EXPECT_LT(pressed.pose.position.z(), kTable);
    EXPECT_NEAR(bench.servo.remote()->remote().contact.stiffness, kSeries, 0.1 * kSeries);
    EXPECT_GE(hand, 5.0);
    EXPECT_NEAR(hand, arm, 0.2 * arm);
    EXPECT_LE(bench.largest_force, 1.5 * arm);
    EXPECT_LE(bench.made(), 0.0);
  }
}

TEST(WorldArm, LiftsTheBox) {
  constexpr double kGrips = 0.03;  // [m]
  Bench bench("delay=25,loss=2,seed=1");
  bench.hand.gripper = kOpen;
  bench.go_over_box();
  bench.move(Vec3(0.0, 0.0, kMat + kBoxHalf - kOverBox.z() + 0.005), 1.0);
  bench.hand.gripper = kGrips;
  bench.run(1.0);
  const double before = bench.box();
  bench.move(Vec3(0.0, 0.0, 0.06), 1.5);
  bench.run(1.0);
  EXPECT_NEAR(bench.box() - before, 0.06, 0.015);
  EXPECT_GT(bench.servo.remote()->remote().gripper, kGrips) << "the box is between the fingers";
  EXPECT_LE(bench.made(), 0.0);
}

/// A hand that leads the arm must not touch the scene itself. Another hand at this position must
/// touch the scene.
TEST(WorldArm, TheHandTouchesWithTheArmAlone) {
  Bench bench;
  test::HandSession other(0x900, "delay=0", 5, {.per_contact = 0.0, .power = 0.0});
  other.options.leads.reset();
  other.servo = Servo(other.hand.spec(), other.parameters, other.options);
  bench.join(other, 0x900);
  bench.others.push_back(&other);
  const Vec3 in_mat(0.4, 0.2, kMat - 0.01);
  bench.hand.put(Vec3(0.4, 0.2, kMat + 0.01));
  other.hand.put(Vec3(0.4, 0.2, kMat + 0.01));
  bench.run(0.3);
  bench.hand.meant = other.hand.meant = in_mat;
  double felt = 0.0, led = 0.0;
  for (int n = 0; n < 1000; ++n) {
    bench.tick();
    led = std::max(led, bench.servo.held().force().norm());
    felt = std::max(felt, other.servo.held().force().norm());
  }
  EXPECT_GT(felt, 1.0);
  EXPECT_EQ(led, 0.0);
}

/// The server keeps a hand at the arm that it moves, for any robot number in its samples. The hand
/// must touch nothing else.
TEST(WorldArm, AHandThatMovesItTouchesNothingElseWhateverItNames) {
  Scene scene = arm_scene();
  std::vector<RemoteSeat> seats(2);
  seats[0] = scene.seats().front();
  seats[0].name = "arm";
  seats[1].name = "another";
  scene.set_seats(seats);
  Bench bench("delay=0", std::move(scene));
  bench.hand.put(Vec3(0.4, 0.2, kMat + 0.01));
  bench.engage();
  ASSERT_EQ(bench.server->link_state(0), engaged);
  bench.names_another = true;
  bench.hand.meant.z() = kMat - 0.01;
  for (int n = 0; n < 500; ++n) {
    bench.tick();
    ASSERT_EQ(bench.reply.command.force().norm(), 0.0) << n;
  }
  EXPECT_LT(bench.servo.sample().pose.position.z(), kMat);
  EXPECT_EQ(bench.server->link_state(0), engaged);
}

/// Other hands feel and push the arm's links. The arm's springs must return the links.
TEST(WorldArm, AnotherHandPushesALink) {
  Bench bench;
  test::HandSession other(0x900, "delay=0", 5, {.per_contact = 0.0, .power = 0.0});
  bench.join(other, 0x900);
  bench.others.push_back(&other);
  bench.engage();
  const Object& palm = bench.object("palm");
  const Vec3 before = palm.pose.position;
  const Vec3 out = palm.pose.orientation * Vec3::UnitZ();  // axis of the capsule
  const Vec3 beside = before + 0.13 * out;                 // in front of the capsule's round end
  other.options.leads.reset();
  other.servo = Servo(other.hand.spec(), other.parameters, other.options);
  other.hand.put(beside);
  bench.run(0.2);
  for (int n = 0; n < 1000; ++n) {
    other.hand.meant = beside - 8e-5 * n * out;
    bench.tick();
  }
  bench.run(1.0);
  EXPECT_GT(other.servo.held().force().norm(), 0.3);
  EXPECT_LT((palm.pose.position - before).dot(out), -3e-4) << "it yields";
  other.hand.meant = beside + 0.1 * out;
  bench.run(2.0);
  EXPECT_NEAR((palm.pose.position - before).dot(out), 0.0, 1e-4);
}

TEST(WorldArm, HoldsWhenTheHandIsSilent) {
  Bench bench;
  bench.go_over_box();
  const Vec3 from = bench.hand.meant;
  for (int n = 0; n < 200; ++n) {  // a movement at 0.1 m/s
    bench.hand.meant = from + Vec3(0.0, 1e-4 * n, 0.0);
    bench.tick();
  }
  bench.silent = true;
  bench.run(0.11);
  EXPECT_EQ(bench.server->link_state(0), hold);
  bench.run(0.3);
  const Vec3 held = bench.arm().target.position;
  bench.run(0.5);
  EXPECT_EQ(bench.arm().target.position, held);
}

TEST(WorldArm, ItsSeatIsForNoOtherRobot) {
  Bench bench;
  const control::Message answer = bench.ask_to_join(bench, 0x800, Role::follower);
  ASSERT_TRUE(std::holds_alternative<control::Refused>(answer));
  EXPECT_THAT(std::get<control::Refused>(answer).reason,
              HasSubstr("the seat of scene 'arm' is for the arm of the scene's own mjcf"));
}

TEST(WorldArm, AReloadPutsItHomeAndTheHandPressesAnew) {
  Bench bench;
  bench.go_over_box();
  const Scene again = arm_scene();
  bench.server->enter(again, bench.now);
  bench.run(0.3);
  EXPECT_NE(bench.server->link_state(0), engaged);
  EXPECT_NEAR(bench.arm().pose.position.z(), 0.486, 0.02);
  EXPECT_LE(bench.made(), 0.0);
  bench.engage();
  EXPECT_EQ(bench.server->link_state(0), engaged);
}

/// A force of 30 N is half of the arm's own spring force. Such a stop must end by itself.
TEST(WorldArm, AProtectiveStopEndsWhenNothingPushes) {
  Scene scene = arm_scene();
  std::vector<RemoteSeat> seats = scene.seats();
  seats.front().arm->stop_force = 4.0;
  scene.set_seats(seats);
  Bench bench("delay=0", std::move(scene));
  bench.go_over_box();
  bench.move(Vec3(-0.1, 0.0, 0.0), 1.0);
  bool stopped = false;
  const Vec3 from = bench.hand.meant;
  for (int n = 0; n < 4000 && !stopped; ++n) {
    bench.hand.meant = from - Vec3(0.0, 0.0, 3e-5 * n);
    bench.tick();
    stopped = bench.arm().stopped;
  }
  ASSERT_TRUE(stopped);
  bench.tick();
  EXPECT_EQ(bench.server->link_state(0), fault);
  bench.hand.pressed = false;
  bench.hand.meant = from;
  bench.run(3.0);
  EXPECT_FALSE(bench.arm().stopped);
  bench.engage();
  EXPECT_EQ(bench.server->link_state(0), engaged);
}

}  // namespace
}  // namespace feltwire::world_arm_test
