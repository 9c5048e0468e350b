#include "gateway/remote_scene/seen_picture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/scene_file/load_scene.hpp"

namespace feltwire::seen_picture_test {
namespace {

using ::testing::ElementsAre;

/// Returns a floor and a moving ball (object 1).
Scene moving() {
  return parse_scene(R"({"name": "box", "materials": [{"name": "wood", "stiffness": 1000}],
    "bodies": [{"name": "loose", "position": [0, 0, 0.05], "mass": 0.1}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"},
                {"name": "ball", "sphere": {"radius": 0.02}, "body": "loose", "material": "wood"}]})",
                     "box.json");
}

SceneView view_of(const std::vector<SeenHand>& hands, const std::vector<SeenBody>& bodies) {
  SceneView view;
  view.present = true;
  view.hands_end = SceneView::kLastHand;
  view.bodies_end = SceneView::kLastBody;
  for (const SeenHand& hand : hands) view.hand[view.hand_count++] = hand;
  for (const SeenBody& body : bodies) view.body[view.body_count++] = body;
  return view;
}

TEST(SeenPicture, HasTheHandsAndWhatMoves) {
  Pose pose;
  pose.position = {0.1, 0.2, 0.3};
  ObservedScene seen;
  seen.take(view_of({{3, pose, Vec3(0, 0, 2)}, {7, {}, Vec3::Zero()}}, {{1, pose}}));
  Picture picture;
  draw(seen, moving(), {}, picture);
  ASSERT_EQ(picture.hands.size(), 2u);
  EXPECT_EQ(picture.hands[0].number, 3u);
  EXPECT_EQ(picture.hands[0].pose.position, pose.position);
  EXPECT_EQ(picture.hands[0].proxy, pose.position);
  EXPECT_EQ(picture.hands[0].held, Vec3(0, 0, 2));
  EXPECT_EQ(picture.hands[0].states, bit(HandState::touching));
  EXPECT_EQ(picture.hands[1].states, bit(HandState::free_space));
  ASSERT_EQ(picture.bodies.size(), 1u);
  EXPECT_EQ(picture.bodies[0].pose.position, pose.position);
  // A hand that left must be removed.
  seen.take(view_of({{7, {}, Vec3::Zero()}}, {}));
  draw(seen, moving(), {}, picture);
  EXPECT_EQ(picture.hands.size(), 1u);
  EXPECT_TRUE(picture.bodies.empty());
}

TEST(SeenPicture, HasTheFiguresOfAHand) {
  SeenHand hand{3, {}, Vec3(0, 0, 2)};
  hand.figures = HandFigures{.samples = 5,
                             .missed = 2,
                             .proxy = {1, 2, 3},
                             .elastic = {0, 0, 4},
                             .frictional = {1, 0, 0},
                             .depth = 0.5,
                             .delivered = 0.25,
                             .burned = 0.75,
                             .states = 0xffffffffu,
                             .report = HandReport{.has_account = true, .balance = 0.125},
                             .tool = 7};
  ObservedScene seen;
  seen.take(view_of({hand}, {}));
  Picture picture;
  draw(seen, moving(), {}, picture);
  ASSERT_EQ(picture.hands.size(), 1u);
  const PictureHand& drawn = picture.hands[0];
  EXPECT_EQ(drawn.samples, 5u);
  EXPECT_EQ(drawn.missed, 2u);
  EXPECT_EQ(drawn.proxy, Vec3(1, 2, 3));
  EXPECT_EQ(drawn.elastic, Vec3(0, 0, 4));
  EXPECT_EQ(drawn.frictional, Vec3(1, 0, 0));
  EXPECT_EQ(drawn.held, Vec3(0, 0, 2));
  EXPECT_EQ(drawn.depth, 0.5);
  EXPECT_EQ(drawn.delivered, 0.25);
  EXPECT_EQ(drawn.burned, 0.75);
  ASSERT_TRUE(drawn.report.has_value());
  EXPECT_EQ(drawn.report->balance, 0.125);
  // Unknown bits must not appear as reasons of the client.
  EXPECT_EQ(drawn.states, (1u << kHandStates) - 1u);
  // A tool that is not in the file must be omitted.
  const auto described = hands_of(seen, moving(), {}, Nanoseconds(0));
  ASSERT_EQ(described.size(), 1u);
  EXPECT_EQ(described[0].number, 3u);
  EXPECT_EQ(described[0].tool, "");
}

TEST(SeenPicture, HasWhatTheServerTellsOfASession) {
  SeenHand hand{3, {}, Vec3::Zero()};
  hand.figures = HandFigures{.report = HandReport{}};
  ObservedScene seen;
  seen.take(view_of({hand, {7, {}, Vec3::Zero()}}, {}));
  control::SessionDescription told;
  told.number = 3;
  told.session = 4711;
  told.client = "alice";
  told.device = "falcon";
  told.parameters.mode = "per_axis";
  told.changes.asked = "mode a -> b";
  told.changes.answer = ChangeAnswer::refused;
  told.lead_share = 2.0;
  told.seconds = 1.5;
  told.hand_damping = 0.25;
  told.times = {{1, 2, 3, 4, 5, 6, 7, 8}, {8, 7, 6, 5, 4, 3, 2, 1}};
  const std::vector all{told};
  Picture picture;
  draw(seen, moving(), all, picture);
  ASSERT_EQ(picture.hands.size(), 2u);
  EXPECT_EQ(picture.hands[0].report->hand_damping, 0.25);
  auto hands = hands_of(seen, moving(), all, std::chrono::seconds(10));
  ASSERT_EQ(hands.size(), 2u);
  EXPECT_EQ(hands[0].session, 4711u);
  EXPECT_EQ(hands[0].client, "alice");
  EXPECT_EQ(hands[0].device, "falcon");
  EXPECT_EQ(hands[0].parameters->mode, "per_axis");
  EXPECT_EQ(hands[0].changes.asked, "mode a -> b");
  EXPECT_EQ(hands[0].changes.answer, ChangeAnswer::refused);
  EXPECT_EQ(hands[0].lead_share, std::nullopt);  // The scene has no robot.
  EXPECT_EQ(hands[0].joined, std::chrono::milliseconds(8500));
  EXPECT_EQ(hands[0].times.wakeups()[7], 8u);
  EXPECT_EQ(hands[0].times.round_trips()[0], 8u);
  EXPECT_EQ(hands[1].client, "");  // The client has just joined and has no description yet.
  EXPECT_EQ(hands[1].parameters, std::nullopt);
  // Impossible parameters must be hidden.
  told.parameters.servo_period = 0.0;
  EXPECT_EQ(hands_of(seen, moving(), std::vector{told}, Nanoseconds(0))[0].parameters,
            std::nullopt);
}

TEST(SeenPicture, TakesTheMaterialsInForce) {
  const Scene scene = moving();
  const Material wood = scene.objects()[0].material;
  const std::vector same{wood, wood};
  EXPECT_FALSE(with_materials(scene, same));
  Material soft = wood;
  soft.stiffness = 250.0;
  soft.static_friction = soft.dynamic_friction = 0.5;
  const auto changed = with_materials(scene, std::vector{wood, soft});
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->objects()[0].material.stiffness, 1000.0);
  EXPECT_EQ(changed->objects()[1].material.stiffness, 250.0);
  EXPECT_EQ(changed->objects()[1].material.dynamic_friction, 0.5);
  // The call must refuse materials of another file and impossible materials.
  EXPECT_FALSE(with_materials(scene, std::vector{soft}));
  soft.stiffness = -1.0;
  EXPECT_FALSE(with_materials(scene, std::vector{wood, soft}));
}

TEST(SeenPicture, LeavesOutWhatTheFileDoesNotHave) {
  ObservedScene seen;
  seen.take(view_of({}, {{0, {}}, {1, {}}, {2, {}}, {60000, {}}}));
  Picture picture;
  draw(seen, moving(), {}, picture);
  ASSERT_EQ(picture.bodies.size(), 1u);
  EXPECT_EQ(picture.bodies[0].object, 1u);
}

}  // namespace
}  // namespace feltwire::seen_picture_test
