// Tests the surfaces that a gateway finds near the observed hands.

#include "gateway/remote_scene/near_surfaces.hpp"

#include <gtest/gtest.h>

#include "core/local_model_extraction/extract.hpp"
#include "core/scene_file/load_scene.hpp"
#include "gateway/remote_scene/seen_picture.hpp"

namespace feltwire::near_surfaces_test {
namespace {

/// Returns a plate of 4 mm (object 0) and a moving ball (object 1).
std::shared_ptr<const Scene> scene() {
  return std::make_shared<const Scene>(
      parse_scene(R"({"name": "plate", "materials": [{"name": "wood", "stiffness": 1000}],
        "bodies": [{"name": "loose", "position": [0, 0, 1], "mass": 0.1}],
        "objects": [{"name": "plate", "box": {"size": [0.2, 0.2, 0.004]}, "material": "wood"},
                    {"name": "ball", "sphere": {"radius": 0.02}, "body": "loose", "material": "wood"}]})",
                  "plate.json"));
}

SeenHand hand_at(double z, std::uint32_t number = 3) {
  SeenHand hand;
  hand.number = number;
  hand.pose.position = {0.01, 0.02, z};
  hand.figures.emplace().samples = 5;
  return hand;
}

control::SessionDescription told_of_hand(std::uint32_t number = 3) {
  control::SessionDescription told;
  told.number = number;
  told.parameters.local_model = true;
  return told;
}

/// An observer of a server.
struct Observer {
  std::shared_ptr<const Scene> scene = near_surfaces_test::scene();
  std::vector<control::SessionDescription> told{told_of_hand()};
  std::vector<SeenBody> bodies;
  ObservedScene seen;
  NearSurfaces near;
  Picture picture;

  LocalModel look(const std::vector<SeenHand>& hands) {
    SceneView view;
    view.present = true;
    view.hands_end = SceneView::kLastHand;
    view.bodies_end = SceneView::kLastBody;
    for (const SeenHand& hand : hands) view.hand[view.hand_count++] = hand;
    for (const SeenBody& body : bodies) view.body[view.body_count++] = body;
    seen.take(view);
    draw(seen, *scene, told, picture);
    near.add(scene, seen, told, picture);
    return picture.hands.empty() ? LocalModel{} : picture.hands.back().surfaces;
  }
};

void expect_same(const LocalModel& found, const LocalModel& wanted) {
  ASSERT_EQ(found.count, wanted.count);
  EXPECT_EQ(found.reach, wanted.reach);
  for (std::size_t i = 0; i < found.view().size(); ++i) {
    const SurfacePatch &a = found.view()[i], &b = wanted.view()[i];
    EXPECT_EQ(a.object, b.object);
    EXPECT_EQ(a.feature, b.feature);
    EXPECT_EQ(a.point, b.point);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.touching, b.touching);
  }
}

TEST(NearSurfaces, AreThoseOfTheServer) {
  Observer observer;
  const ToolView& view = *observer.scene;
  TouchMemory memory = view.memory();
  // The hand moves down into the plate, far beyond the middle. The face of the entry must hold the
  // hand. Only the path of the hand determines this face.
  for (const double z : {0.05, 0.01, 0.002, 0.001, -0.001, -0.0019}) {
    const LocalModel found = observer.look({hand_at(z)});
    view.touch({hand_at(z).pose.position}, memory);
    expect_same(found, local_model(view, hand_at(z).pose.position, memory));
    ASSERT_GT(found.count, 0);
    EXPECT_EQ(found.view()[0].touching, z < 0.002);
    EXPECT_EQ(found.view()[0].normal, Vec3(0, 0, 1));
  }
}

TEST(NearSurfaces, OfABodyAreWhereItIsSeen) {
  Observer observer;
  SeenBody ball{1, {}};
  ball.pose.position = {0.01, 0.02, 0.1};
  observer.bodies = {ball};
  const LocalModel above =
      observer.look({hand_at(0.13)});  // The hand is 10 mm above the ball, and far from the plate.
  ASSERT_EQ(above.count, 1);
  EXPECT_EQ(above.view()[0].object, 1);
  EXPECT_LT((above.view()[0].point - Vec3(0.01, 0.02, 0.12)).norm(), 1e-12);
  EXPECT_FALSE(above.view()[0].touching);
  EXPECT_TRUE(observer.look({hand_at(0.115)}).view()[0].touching);
  // The ball is gone, so only the plate is near.
  observer.bodies[0].pose.position.x() = 5.0;
  const LocalModel gone = observer.look({hand_at(0.05)});
  ASSERT_GT(gone.count, 0);
  for (const SurfacePatch& patch : gone.view()) EXPECT_EQ(patch.object, 0);
}

TEST(NearSurfaces, HasWhoseClientRendersThem) {
  Observer observer;
  EXPECT_GT(observer.look({hand_at(0.01)}).count, 0);
  observer.told[0].parameters.local_model = false;
  EXPECT_EQ(observer.look({hand_at(0.01)}).count, 0);
  observer.told = {told_of_hand(4)};  // This session belongs to another hand.
  EXPECT_EQ(observer.look({hand_at(0.01)}).count, 0);
  EXPECT_GT(observer.look({hand_at(0.01, 4)}).count, 0);
  observer.told = {told_of_hand()};
  SeenHand hand = hand_at(0.01);
  hand.figures->samples = 0;  // Without a sample, the position is unknown.
  EXPECT_EQ(observer.look({hand}).count, 0);
  hand.figures.reset();  // An older server sends no figures.
  EXPECT_EQ(observer.look({hand}).count, 0);
  hand = hand_at(0.01);
  hand.figures->tool = 7;  // This tool is not in the file.
  EXPECT_EQ(observer.look({hand}).count, 0);
  EXPECT_GT(observer.look({hand_at(0.01)}).count, 0);
}

TEST(NearSurfaces, AreOfTheFirstHandsOnly) {
  Observer observer;
  observer.told.clear();
  for (std::uint32_t number = 1; number <= kMostPictureSurfaces + 1; ++number) {
    observer.told.push_back(told_of_hand(number));
    SceneView view;
    view.present = true;
    view.hands_from = number;
    view.hands_end = number + 1;
    view.hand[view.hand_count++] = hand_at(0.01, number);
    observer.seen.take(view);
  }
  draw(observer.seen, *observer.scene, observer.told, observer.picture);
  observer.near.add(observer.scene, observer.seen, observer.told, observer.picture);
  ASSERT_EQ(observer.picture.hands.size(), kMostPictureSurfaces + 1);
  EXPECT_GT(observer.picture.hands[kMostPictureSurfaces - 1].surfaces.count, 0);
  EXPECT_EQ(observer.picture.hands.back().surfaces.count, 0);
}

}  // namespace
}  // namespace feltwire::near_surfaces_test
