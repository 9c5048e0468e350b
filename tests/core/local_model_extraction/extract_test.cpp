// Tests the local model of a scene near a tool: its surfaces and its valid radius.

#include "core/local_model_extraction/extract.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/local_model/local_contact.hpp"

namespace feltwire::extract_test {
namespace {

Scene of(std::vector<Object> objects) { return Scene("scene", std::move(objects)); }
Object object(const char* name, const Shape& shape, const Vec3& position = Vec3::Zero()) {
  Object o;
  o.name = name;
  o.shape = shape;
  o.pose.position = position;
  return o;
}

TEST(Near, KnowsAWallBeforeItIsTouched) {
  const Scene floor = of({object("floor", Plane{})});
  const LocalModel model = local_model(floor, Vec3(0.3, -0.2, 0.05), floor.memory());
  ASSERT_EQ(model.count, 1);
  EXPECT_EQ(model.patches[0].point, Vec3(0.3, -0.2, 0.0));
  EXPECT_EQ(model.patches[0].normal, Vec3::UnitZ());
  EXPECT_FALSE(model.patches[0].touching);
  EXPECT_EQ(model.reach, kModelReach);
  // The model must report that the space beyond its largest radius is empty.
  const LocalModel far = local_model(floor, Vec3(0, 0, 0.11), floor.memory());
  EXPECT_EQ(far.count, 0);
  EXPECT_EQ(far.reach, kModelReach);
  const Scene block = of({object("block", Box{Vec3(0.05, 0.05, 0.05)})});
  const auto faces = [&](double x, double z) {
    return local_model(block, Vec3(x, 0, z), block.memory()).count;
  };
  EXPECT_EQ(faces(0.0, 0.151), 0);
  EXPECT_EQ(faces(0.0, 0.149), 1);   // The edges are farther than 0.1 m.
  EXPECT_EQ(faces(0.04, 0.149), 2);  // An edge is nearer.
  EXPECT_EQ(faces(0.06, 0.149), 2);  // Beyond both faces, the edge is nearest.
  EXPECT_EQ(faces(0.06, 0.1495), 0);
}

TEST(Near, ReachEndsBeforeWhatIsLeftOut) {
  std::vector<Object> balls;
  for (int i = 0; i < 5; ++i)
    balls.push_back(object(
        ("ball " + std::to_string(i)).c_str(), Sphere{0.01},
        Vec3(0.0, 0.0, 0.0) + (0.02 + 0.01 * i) * Vec3(std::cos(1.3 * i), std::sin(1.3 * i), 0.0)));
  const Scene scene = of(balls);
  const LocalModel model = local_model(scene, Vec3::Zero(), scene.memory());
  ASSERT_EQ(model.count, 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(model.patches[static_cast<std::size_t>(i)].object, i);
  EXPECT_NEAR(model.reach, 0.04, 1e-15);  // distance to the fourth ball's surface
}

// The side and the ends of a capsule form one smooth surface, but need several patches.
TEST(Near, ReachEndsWhereACapsuleBendsAway) {
  const Scene scene = of({object("capsule", Capsule{0.02, 0.04})});
  const auto at = [&](double x, double z) {
    return local_model(scene, Vec3(x, 0.0, z), scene.memory());
  };
  for (const LocalModel& model : {at(0.021, 0.03), at(0.019, 0.03)}) {
    ASSERT_EQ(model.count, 1);
    EXPECT_EQ(model.patches[0].axis, Vec3::UnitZ());
    EXPECT_NEAR(model.patches[0].radius, 0.01, 1e-15);
  }
  EXPECT_NEAR(at(0.019, 0.03).reach, 0.01, 1e-15);
  EXPECT_NEAR(at(0.05, 0.0).reach, 0.05, 1e-15);  // 40 mm along and 30 mm inwards
  EXPECT_EQ(at(0.0, 0.07).patches[0].axis, Vec3::Zero());
  EXPECT_NEAR(at(0.0, 0.07).reach, 0.03, 1e-15);
}

TEST(Near, InFourWallsAtOnceItSaysNothing) {
  std::vector<Object> walls;
  for (int i = 0; i < 4; ++i)
    walls.push_back(object(("wall " + std::to_string(i)).c_str(), Plane{}));
  const Scene scene = of(walls);
  TouchMemory memory = scene.memory();
  scene.touch({Vec3(0, 0, -1e-3), Vec3::Zero()}, memory);
  const LocalModel model = local_model(scene, Vec3(0, 0, -1e-3), memory);
  EXPECT_EQ(model.reach, 0.0);
  LocalContact local;
  local.take(model);
  EXPECT_EQ(local.touch({Vec3(0, 0, -1e-3), Vec3::Zero()}, 0.0, 1e-3).weight, 0.0);
}

TEST(Near, APositionThatIsNoneGivesNone) {
  const Scene floor = of({object("floor", Plane{})});
  const double nan = std::nan("");
  EXPECT_EQ(local_model(floor, Vec3(0, nan, 0), floor.memory()).reach, 0.0);
  EXPECT_EQ(local_model(floor, Vec3::Zero(), TouchMemory(3)).reach, 0.0);
}

}  // namespace
}  // namespace feltwire::extract_test
