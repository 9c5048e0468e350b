// An observer of a scene with a robot must see tool, target, state and force, and also the hands.

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <variant>

#include "protocol/session/profiles.hpp"
#include "server/picture/picture.hpp"
#include "tests/client/simulated_robots/teleoperation_bench.hpp"

namespace feltwire::teleoperation_observer_test {
namespace {

using test::Teleoperation;
using enum LinkState;

/// An observer without a link. Each look sends a sample and takes the answer.
class ObserverClient {
 public:
  ObserverClient(Teleoperation& bench, std::uint64_t id, bool figures = false)
      : bench_(bench), datagrams_(id, test::keys(id), usual_parameters(), false) {
    control::JoinRequest request{"eye", "empty", bench.hand.spec(), usual_parameters(),
                                 Role::observer};
    request.figures = figures;
    EXPECT_TRUE(std::holds_alternative<control::JoinAccepted>(
        bench.server->answer(request, id, test::keys(id), bench.now)));
  }
  const SceneView& look() {
    ++sample_.index;
    sample_.client_time = bench_.now;
    answer_ = bench_.server->receive(datagrams_.pack(sample_, {}, std::nullopt), bench_.hand_peer,
                                     bench_.now, bench_.room);
    Reply reply;
    GoodbyeReason reason{};
    EXPECT_EQ(datagrams_.take(answer_, reply, reason), DatagramSession::Arrival::reply);
    EXPECT_FALSE(reply.remote) << "an observer leads nothing";
    return *datagrams_.view();
  }
  std::size_t size() const { return answer_.size(); }

 private:
  Teleoperation& bench_;
  DatagramSession datagrams_;
  Sample sample_;
  Bytes answer_;
};

TEST(TeleoperationObserver, SeesTheRobotThatAHandLeads) {
  Teleoperation bench;
  ObserverClient eye(bench, 0x900);
  bench.run(0.1);
  EXPECT_EQ(eye.look().robot->state, ready);
  bench.engage();
  bench.move(Vec3(0.0, 0.0, -0.045), 0.6);
  bench.run(0.5);
  const SceneView& view = eye.look();
  ASSERT_TRUE(view.robot);
  const SeenRobot& robot = *view.robot;
  EXPECT_EQ(robot.state, engaged);
  EXPECT_EQ(robot.hand, 1u) << "the first that joined";
  EXPECT_LE((robot.pose.position - bench.robot.position()).norm(), 1e-5);
  EXPECT_LE((robot.target.position - bench.commanded.position).norm(), 1e-6);
  ASSERT_TRUE(robot.force);
  EXPECT_GE(robot.force->z(), 1.0);
  EXPECT_LE((*robot.force - bench.robot.force()).norm(), 0.2);
  EXPECT_TRUE(robot.ok && robot.touches);
  EXPECT_FALSE(robot.stopped);
  EXPECT_LE(robot.age, 0.01);
  ASSERT_EQ(view.hand_count, 1u) << "and the robot is no hand";
  EXPECT_EQ(view.hands()[0].number, 1u);

  Picture picture;  // a picture for the live page
  bench.server->draw(picture, bench.now);
  ASSERT_EQ(picture.robots.size(), 1u);
  EXPECT_EQ(picture.robots[0].state, engaged);
  EXPECT_LE((picture.robots[0].pose.position - bench.robot.position()).norm(), 1e-5);

  bench.robot.stop(true);
  bench.run(0.01);
  EXPECT_TRUE(eye.look().robot->stopped);
  EXPECT_EQ(eye.look().robot->state, fault);
  bench.server->answer(control::LeaveRequest{Teleoperation::kRobot}, 0, {}, bench.now);
  EXPECT_FALSE(eye.look().robot);
  bench.server->draw(picture, bench.now);
  EXPECT_TRUE(picture.robots.empty());
}

/// The robot's part reduces the room for hands and bodies. Every view must fit in a datagram.
TEST(TeleoperationObserver, EveryViewFitsADatagram) {
  for (const bool figures : {false, true}) {
    Teleoperation bench;
    bench.server = std::make_unique<SceneSessions>(bench.scene, std::chrono::seconds(2), 64);
    bench.join(Teleoperation::kRobot, Role::follower);
    for (std::uint64_t id = 0xa00; id < 0xa00 + 40; ++id) {
      bench.join(id, Role::operator_);
      DatagramSession hand(id, test::keys(id), bench.parameters, false);
      Sample sample;
      sample.index = 1;
      bench.server->receive(hand.pack(sample, {}, std::nullopt), bench.hand_peer, bench.now,
                            bench.room);
    }
    bench.tick();
    bench.tick();
    ObserverClient eye(bench, 0x900, figures);
    std::size_t seen = 0;
    for (int i = 0; i < 20; ++i) {
      const SceneView& view = eye.look();
      ASSERT_TRUE(view.robot);
      seen += view.hand_count;
      EXPECT_LE(eye.size(), 1200u);
      const std::size_t hand = SceneView::kHandSize + (figures ? SceneView::kFiguresSize : 0);
      EXPECT_LE(view.hand_count * hand + kSeenRobotRoom, view_room(1e-3))
          << "bodies, torque and rates need the rest";
    }
    EXPECT_GE(seen, 40u) << "all hands come round";
  }
}

TEST(TeleoperationObserver, WithoutARobotThereIsNone) {
  Teleoperation bench;
  bench.server = std::make_unique<SceneSessions>(bench.scene, std::chrono::seconds(2), 8);
  ObserverClient eye(bench, 0x900);
  EXPECT_FALSE(eye.look().robot);
  bench.join(Teleoperation::kRobot, Role::follower);
  EXPECT_FALSE(eye.look().robot) << "it has said nothing yet";
}

}  // namespace
}  // namespace feltwire::teleoperation_observer_test
