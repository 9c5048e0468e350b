#include "client/run/observed_scene.hpp"

#include <gmock/gmock.h>

#include "client/run/observer_recorder.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::observed_scene_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::text_of;

/// Returns a view with these hands and bodies at a fixed position.
SceneView view_of(std::uint32_t from, std::uint32_t end, const std::vector<std::uint32_t>& hands,
                  const std::vector<std::uint16_t>& bodies = {}) {
  SceneView view;
  view.present = true;
  view.hands_from = from;
  view.hands_end = end;
  view.bodies_end = bodies.empty() ? 0 : SceneView::kLastBody;
  for (const std::uint32_t number : hands)
    view.hand[view.hand_count++] = {number, Pose{.position = {0.5, 0, -0.25}}, Vec3(0, 0, 1.5)};
  for (const std::uint16_t object : bodies)
    view.body[view.body_count++] = {object, Pose{.position = {1, 2, 3}}};
  return view;
}

std::vector<std::uint32_t> numbers(const ObservedScene& scene) {
  std::vector<std::uint32_t> all;
  for (const auto& [number, hand] : scene.hands()) all.push_back(number);
  return all;
}

TEST(ObservedScene, IsPutTogetherFromParts) {
  ObservedScene scene;
  scene.take(view_of(0, 5, {1, 3, 4}));
  scene.take(view_of(5, SceneView::kLastHand, {5, 9}, {2, 3}));
  EXPECT_THAT(numbers(scene), ElementsAre(1, 3, 4, 5, 9));
  EXPECT_EQ(scene.bodies().size(), 2u);
  EXPECT_EQ(scene.bodies().at(3).pose.position, Vec3(1, 2, 3));
  EXPECT_THAT(scene.hands_gone(), IsEmpty());
}

TEST(ObservedScene, WhoWasPassedOverIsGone) {
  ObservedScene scene;
  scene.take(view_of(0, SceneView::kLastHand, {1, 3, 4, 9}, {2, 3}));
  scene.take(view_of(2, 5, {4}));  // This view excludes the hands 1 and 9.
  EXPECT_THAT(scene.hands_gone(), ElementsAre(3));
  EXPECT_THAT(numbers(scene), ElementsAre(1, 4, 9));
  EXPECT_EQ(scene.bodies().size(), 2u);
  scene.take(view_of(5, SceneView::kLastHand, {}, {3}));
  EXPECT_THAT(scene.hands_gone(), ElementsAre(9));
  EXPECT_THAT(scene.bodies_gone(), ElementsAre(2));
  scene.take(view_of(0, 5, {}));
  EXPECT_THAT(scene.hands_gone(), ElementsAre(1, 4));
  EXPECT_THAT(numbers(scene), IsEmpty());
}

TEST(ObservedScene, TheNewestPlaceCounts) {
  ObservedScene scene;
  SceneView view = view_of(0, SceneView::kLastHand, {7});
  scene.take(view);
  view.hand[0].pose.position.x() = 0.75;
  scene.take(view);
  EXPECT_EQ(scene.hands().at(7).pose.position.x(), 0.75);
}

/// A server sends new hands and bodies forever.
TEST(ObservedScene, KeepsNoMoreThanItsLimitsAndCountsTheRest) {
  ObservedScene scene;
  std::uint32_t number = 0;
  std::uint16_t object = 0;
  std::uint64_t shown = 0;
  for (int round = 0; round < 2000; ++round) {
    SceneView view;
    view.present = true;
    view.hands_from = number + 1;  // The view excludes earlier hands, so none is removed.
    view.bodies_from = static_cast<std::uint16_t>(object + 1);
    for (; view.hand_count < SceneView::kMaxHands; ++view.hand_count)
      view.hand[view.hand_count].number = ++number;
    for (; view.body_count < SceneView::kMaxBodies && object < SceneView::kLastBody - 1;
         ++view.body_count)
      view.body[view.body_count].object = ++object;
    view.hands_end = number + 1;
    view.bodies_end = static_cast<std::uint16_t>(object + 1);
    shown += view.hand_count + view.body_count;
    scene.take(view);
    ASSERT_LE(scene.hands().size(), ObservedScene::kMostHands);
    ASSERT_LE(scene.bodies().size(), ObservedScene::kMostBodies);
  }
  EXPECT_EQ(scene.left_out(), shown - ObservedScene::kMostHands - ObservedScene::kMostBodies);
  // A hand that leaves makes room. The view still updates a known hand.
  SceneView view = view_of(1, 11, {5, 6});
  view.hand[0].pose.position.x() = 0.75;
  scene.take(view);
  EXPECT_EQ(scene.hands_gone().size(), 8u);
  EXPECT_EQ(scene.hands().at(5).pose.position.x(), 0.75);
  const std::uint64_t before = scene.left_out();
  scene.take(view_of(number, number + 2, {number + 1}));
  EXPECT_EQ(scene.hands().count(number + 1), 1u);
  EXPECT_EQ(scene.left_out(), before);
}

TEST(ObserverRecorder, SaysWhatItHasNoRoomFor) {
  EXPECT_EQ(text(SightCounts{.hands = 2, .bodies = 1, .left_out = 3}),
            "  sees 2 hands, 1 body, 3 left out");
  EXPECT_EQ(text(SightCounts{.robots = {LinkState::hold}}),
            "  sees 0 hands, 0 bodies, a robot (hold)");
}

TEST(ObserverRecorder, CountsAndWritesDownWhatItSees) {
  const testing::TemporaryFolder folder;
  const auto file = folder / "view.csv";
  ObserverRecorder observer(file);
  observer.views().push({0.25, view_of(0, SceneView::kLastHand, {2, 7}, {4})});
  observer.look();
  EXPECT_EQ(text(observer.counts()), "  sees 2 hands, 1 body");
  observer.views().push({0.5, view_of(0, SceneView::kLastHand, {7})});
  SceneView empty = view_of(0, 0, {});
  empty.bodies_end = SceneView::kLastBody;
  observer.views().push({0.75, empty});
  observer.look();
  EXPECT_EQ(text_of(file),
            "t,kind,id,x,y,z,qw,qx,qy,qz,fx,fy,fz\n"
            "0.25,hand,2,0.5,0,-0.25,1,0,0,0,0,0,1.5\n"
            "0.25,hand,7,0.5,0,-0.25,1,0,0,0,0,0,1.5\n"
            "0.25,body,4,1,2,3,1,0,0,0,,,\n"
            "0.5,hand,7,0.5,0,-0.25,1,0,0,0,0,0,1.5\n"
            "0.5,hand_gone,2,,,,,,,,,,\n"
            "0.75,body_gone,4,,,,,,,,,,\n");
  EXPECT_EQ(text(observer.counts()), "  sees 1 hand, 0 bodies");
  EXPECT_EQ(observer.counts().views, 3u);
  EXPECT_EQ(observer.counts().most_hands, 2u);
  EXPECT_EQ(observer.counts().most_bodies, 1u);
}

TEST(ObserverRecorder, WritesDownTheRobot) {
  const testing::TemporaryFolder folder;
  const auto file = folder / "view.csv";
  ObserverRecorder observer(file);
  SceneView view = view_of(0, 0, {});
  SeenRobot& robot = view.robot.emplace();
  robot.pose.position = Vec3(0.25, 0.0, 1.0);
  robot.target.position = Vec3(0.5, 0.0, 1.0);
  robot.force = Vec3(0.0, -2.0, 3.0);
  robot.state = LinkState::engaged;
  robot.hand = 7;
  observer.views().push({0.25, view});
  observer.look();
  EXPECT_EQ(observer.counts().robots, std::vector{LinkState::engaged});
  EXPECT_EQ(observer.scene().robots().at(0).hand, 7u);
  robot.force.reset();
  robot.state = LinkState::fault;
  robot.hand = 0;
  observer.views().push({0.5, view});
  view.robot.reset();
  observer.views().push({0.75, view});
  observer.views().push({1.0, view});
  observer.look();
  EXPECT_TRUE(observer.counts().robots.empty());
  EXPECT_TRUE(observer.scene().robots().empty());
  EXPECT_EQ(text_of(file),
            "t,kind,id,x,y,z,qw,qx,qy,qz,fx,fy,fz\n"
            "0.25,robot,2,0.25,0,1,1,0,0,0,0,-2,3\n"
            "0.25,robot_target,7,0.5,0,1,1,0,0,0,,,\n"
            "0.5,robot,5,0.25,0,1,1,0,0,0,,,\n"
            "0.5,robot_target,0,0.5,0,1,1,0,0,0,,,\n"
            "0.75,robot_gone,0,,,,,,,,,,\n");
}

TEST(ObserverRecorder, TellsSeveralRobotsApart) {
  EXPECT_EQ(text(SightCounts{.robots = {LinkState::hold, LinkState::engaged}}),
            "  sees 0 hands, 0 bodies, 2 robots (hold, engaged)");
  const testing::TemporaryFolder folder;
  const auto file = folder / "view.csv";
  ObserverRecorder observer(file);
  SceneView view = view_of(0, 0, {});
  SeenRobot& robot = view.robot.emplace();
  robot.seats = 0b101;
  observer.views().push({0.25, view});
  robot.seat = 2;
  robot.state = LinkState::engaged;
  observer.views().push({0.5, view});
  observer.look();
  EXPECT_EQ(observer.counts().robots, (std::vector{LinkState::disabled, LinkState::engaged}));
  robot.seats = 0b100;
  observer.views().push({0.75, view});
  observer.look();
  EXPECT_EQ(observer.scene().robots().size(), 1u);
  EXPECT_EQ(observer.scene().robots().count(2), 1u);
  EXPECT_EQ(text_of(file),
            "t,kind,id,x,y,z,qw,qx,qy,qz,fx,fy,fz\n"
            "0.25,robot,0,0,0,0,1,0,0,0,,,\n"
            "0.25,robot_target,0,0,0,0,1,0,0,0,,,\n"
            "0.5,robot3,2,0,0,0,1,0,0,0,,,\n"
            "0.5,robot3_target,0,0,0,0,1,0,0,0,,,\n"
            "0.75,robot3,2,0,0,0,1,0,0,0,,,\n"
            "0.75,robot3_target,0,0,0,0,1,0,0,0,,,\n"
            "0.75,robot_gone,0,,,,,,,,,,\n");
}

TEST(ObserverRecorder, SaysWhyItCannotWrite) {
  EXPECT_THAT(
      testing::error_of<std::runtime_error>([] { ObserverRecorder("/proc/nowhere/at/all.csv"); }),
      ::testing::AllOf(::testing::HasSubstr("/proc/nowhere/at/all.csv: No such file"),
                       ::testing::HasSubstr("--view")));
}

}  // namespace
}  // namespace feltwire::observed_scene_test
