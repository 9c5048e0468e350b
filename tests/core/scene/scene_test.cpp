#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/scene_file/load_scene.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::scene_test {
namespace {

Object object(const char* name, Shape shape, Material material = {}) {
  Object o;
  o.name = name;
  o.shape = shape;
  o.material = material;
  return o;
}

/// Returns two planes at a right angle, solid below z = 0 and below x = 0.
std::vector<Object> corner() {
  Object floor = object("floor", Plane{}, {.stiffness = 1000});
  Object wall = object("wall", Plane{}, {.stiffness = 500});
  wall.pose.orientation = Quaternion(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));
  return {floor, wall};
}

TEST(Scene, SumsWhatItsObjectsAnswer) {
  const Scene scene("corner", corner());
  TouchMemory memory = scene.memory();
  ASSERT_EQ(memory.size(), 2u);
  const Command c = scene.touch({Vec3(-0.002, 0, -0.001), Vec3::Zero()}, memory);
  EXPECT_NEAR((c.elastic - Vec3(1, 0, 1)).norm(), 0.0, 1e-12);
  EXPECT_TRUE(memory[0].touching);
  EXPECT_TRUE(memory[1].touching);
}

TEST(Scene, RequiresOnlyWhatAnObjectNeeds) {
  const auto needs = [](Material m) {
    return Scene("s", {object("a", Plane{}), object("b", Plane{}, m)}).requirements();
  };
  EXPECT_FALSE(needs({}).friction);
  EXPECT_FALSE(needs({}).velocity);
  EXPECT_TRUE(needs({.static_friction = 0.1}).friction);
  EXPECT_FALSE(needs({.static_friction = 0.1}).velocity);
  EXPECT_TRUE(needs({.damping = 0.1}).velocity);
  EXPECT_TRUE(needs({.viscous_friction = 0.1}).velocity);
  EXPECT_FALSE(needs({.viscous_friction = 0.1}).friction);
  // the largest stiffness of all materials
  EXPECT_EQ(needs({.stiffness = 2500.0}).stiffness, 2500.0);
  EXPECT_EQ(needs({.stiffness = 10.0}).stiffness, Material{}.stiffness);
}

TEST(Scene, AToolThatIsNotFiniteGivesZeroAndIsForgotten) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const Scene scene("plane",
                    {object("plane", Plane{}, {.stiffness = 1000, .static_friction = 1.0})});
  TouchMemory memory = scene.memory();
  scene.touch({Vec3(0.1, 0.2, -0.001), Vec3::Zero()}, memory);
  for (const Tool& bad :
       {Tool{Vec3(nan, 0, -1), Vec3::Zero()}, Tool{Vec3(0, 0, -infinity), Vec3::Zero()},
        Tool{Vec3(0, 0, -1), Vec3(0, nan, 0)}}) {
    EXPECT_EQ(scene.touch(bad, memory).force(), Vec3::Zero());
    EXPECT_TRUE(memory[0].touching);
    EXPECT_EQ(memory[0].anchor, Vec3(0.1, 0.2, 0.0));
  }
  // The stick point must stay, and the next good sample must continue from it.
  const Command c = scene.touch({Vec3(0.1005, 0.2, -0.001), Vec3::Zero()}, memory);
  EXPECT_NEAR(c.frictional.x(), -0.5, 1e-12);
}

TEST(Scene, AForeignMemoryGivesNoForce) {
  const Scene scene("corner", corner());
  TouchMemory foreign(1);
  EXPECT_EQ(scene.touch({Vec3(-1, 0, -1), Vec3::Zero()}, foreign).force(), Vec3::Zero());
}

TEST(Scene, TakesOrientationsThatAreNotUnit) {
  for (const double scale : {1e-200, 0.5, 1e200}) {
    Object o = object("plane", Plane{}, {.stiffness = 1000});
    o.pose.orientation = Quaternion(scale, -scale, 0, 0);  // rotates +z to +y
    const Scene scene("s", {o});
    TouchMemory memory = scene.memory();
    const Command c = scene.touch({Vec3(0, -0.001, 0), Vec3::Zero()}, memory);
    EXPECT_NEAR((c.elastic - Vec3(0, 1, 0)).norm(), 0.0, 1e-12);
  }
}

TEST(Scene, RefusesWhatBreaksARule) {
  const double nan = std::nan("");
  const Object good = object("ball", Sphere{0.1}, {.stiffness = 100});
  using Break = std::function<void(Object&)>;
  const std::vector<std::pair<std::string, Break>> broken = {
      {"name", [](Object& o) { o.name.clear(); }},
      {"radius", [](Object& o) { o.shape = Sphere{0.0}; }},
      {"radius", [&](Object& o) { o.shape = Sphere{nan}; }},
      {"size.y", [](Object& o) { o.shape = Box{Vec3(1, -1, 1)}; }},
      {"length",
       [](Object& o) {
         o.shape = Capsule{1, -1};
       }},
      {"length",
       [](Object& o) {
         o.shape = Cylinder{1, 0};
       }},
      {"radius",
       [](Object& o) {
         o.shape = Cylinder{1e9, 1};
       }},
      {"stiffness", [](Object& o) { o.material.stiffness = 0; }},
      {"damping", [](Object& o) { o.material.damping = -1; }},
      {"viscous_friction", [&](Object& o) { o.material.viscous_friction = nan; }},
      {"dynamic_friction", [](Object& o) { o.material.dynamic_friction = 0.1; }},
      {"position.z", [&](Object& o) { o.pose.position.z() = nan; }},
      {"orientation", [](Object& o) { o.pose.orientation.coeffs().setZero(); }},
  };
  EXPECT_NO_THROW(Scene("s", {good}));
  for (const auto& [field, make] : broken) {
    Object o = good;
    make(o);
    try {
      Scene("s", {o});
      ADD_FAILURE() << field << " was let through";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(": " + field + ": "));
    }
  }
  EXPECT_THROW(Scene("s", {}), std::invalid_argument);
  EXPECT_THROW(Scene("", {good}), std::invalid_argument);
  EXPECT_THROW(Scene("s", {good, good}), std::invalid_argument);  // Both objects have one name.
}

TEST(Scene, TouchNeverAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  const Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/room.json");
  TouchMemory memory = scene.memory();
  double sum = 0.0;
  const std::size_t before = test::allocations();
  for (int i = 0; i < 10000; ++i) {
    const double t = 1e-3 * i;
    const Vec3 p(0.21 * std::sin(t), 0.21 * std::sin(1.7 * t), -0.04 + 0.03 * std::sin(2.3 * t));
    sum += scene.touch({p, Vec3(0.1, 0.1, 0.1)}, memory).force().norm();
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace feltwire::scene_test
