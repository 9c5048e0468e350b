// The proxy of a solid remembers its side. Thin solids must hold a hand of any force and speed.

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/splitmix.hpp"
#include "tests/core/model_side.hpp"
#include "tests/core/moving.hpp"

namespace feltwire::proxy_side_test {
namespace {

using test::body;
using test::Hand;
using test::kWeightless;
using test::moving;
using test::object;

/// Uniform random numbers from -most to most.
class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}
  double operator()(double most) {
    constexpr double kUnit = 0x1p-63;
    return most * (kUnit * static_cast<double>(splitmix::draw(seed_, drawn_++)) - 1.0);
  }
  Vec3 vector(double most) {
    const double x = (*this)(most), y = (*this)(most);
    return {x, y, (*this)(most)};
  }

 private:
  std::uint64_t seed_, drawn_ = 0;
};

struct Flat {
  const char* name;
  Shape shape;
  Vec3 out;     // normal of the face
  double half;  // [m] from the middle to the face
  Vec3 beside;  // [m] a point on the face
};

/// Returns each flat face of solids that are 1 mm thin.
std::vector<Flat> flat_faces() {
  std::vector<Flat> all;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 half = Vec3::Constant(0.05);
    half[axis] = 5e-4;
    Vec3 beside(0.01, -0.02, 0.03);
    beside[axis] = 0.0;
    for (const double sign : {1.0, -1.0})
      all.push_back({"box", Box{half}, sign * Vec3::Unit(axis), 5e-4, beside});
  }
  for (const double sign : {1.0, -1.0})
    all.push_back({"disc", Cylinder{0.05, 5e-4}, sign * Vec3::UnitZ(), 5e-4, {0.01, -0.02, 0.0}});
  return all;
}

TEST(ProxySide, AThinPlateHoldsAtAnyDepthAndLetsGoWhereItWasEntered) {
  for (const Flat& face : flat_faces())
    for (const double step : {1e-4, 1e-3, 1e-2}) {  // [m] per sample: 0.1, 1 and 10 m/s at 1 kHz
      FeatureMemory memory;
      const auto at = [&](double height) {
        return surface_point(face.shape, Side::outside, face.beside + height * face.out, memory);
      };
      double height = 0.0123;
      for (; height > -1.0; height -= step) {
        const SurfacePoint s = at(height);
        const double depth = std::max(0.0, face.half - height);
        ASSERT_NEAR(s.depth, depth, 1e-12) << face.name << " " << height;
        if (depth > 0.0) {
          ASSERT_EQ(s.normal, face.out) << face.name;
        }
      }
      for (; height < 0.0123; height += step)
        ASSERT_NEAR(at(height).depth, std::max(0.0, face.half - height), 1e-12) << face.name;
      // Beside the plate nothing must hold the hand. From below, the hand then touches the other
      // face.
      const Vec3 out = 0.06 * (face.out.cross(Vec3(1, 2, 3))).normalized() * std::sqrt(2.0);
      EXPECT_EQ(surface_point(face.shape, Side::outside, out, memory).depth, 0.0);
      EXPECT_EQ(surface_point(face.shape, Side::outside, out - 0.03 * face.out, memory).depth, 0.0);
      EXPECT_EQ(at(-0.03).depth, 0.0);
      EXPECT_NEAR(at(0.01).depth, 0.01 + face.half, 1e-12);
    }
}

struct Solid {
  const char* name;
  Shape shape;
};
const Solid kSolids[] = {{"box", Box{Vec3(0.02, 0.03, 5e-4)}}, {"ball", Sphere{0.004}},
                         {"rod", Capsule{0.003, 0.02}},        {"can", Cylinder{0.01, 0.015}},
                         {"disc", Cylinder{0.02, 5e-4}},       {"wire", Cylinder{5e-4, 0.02}},
                         {"cone", Cone{0.01, 0.015}},          {"needle", Cone{2e-3, 0.03}}};

/// The hand moves from all sides to the middle of the solid, with steps of up to 10 m/s at 1 kHz.
TEST(ProxySide, NothingIsPassedStraightThroughItsMiddle) {
  Random random(5);
  for (const Solid& solid : kSolids)
    for (int run = 0; run < 300; ++run) {
      const Vec3 way = random.vector(1.0).normalized();
      const double step = run % 3 == 0 ? 1e-2 : run % 3 == 1 ? 1e-3 : 1e-4;
      FeatureMemory memory;
      Vec3 p = (-0.1 - std::abs(random(step))) * way;
      ASSERT_EQ(surface_point(solid.shape, Side::outside, p, memory).depth, 0.0);
      double before = 0.0;
      while (p.dot(way) < 5e-4) {
        p += step * way;
        const SurfacePoint s = surface_point(solid.shape, Side::outside, p, memory);
        ASSERT_GE(s.depth, before - 1e-12) << solid.name << " run " << run;
        before = s.depth;
        if (s.depth > 0.0) {
          ASSERT_LT(s.normal.dot(way), 0.0) << solid.name << " run " << run;
        }
      }
      ASSERT_GT(before, 0.0) << solid.name << " run " << run;
    }
}

/// A hand moves to and fro at random. The force must not grow faster than the hand's movement
/// allows.
TEST(ProxySide, NoForceRisesFasterThanTheHandMoves) {
  for (const Solid& solid : kSolids) {
    int touched = 0;
    for (std::uint64_t run = 0; run < 40; ++run) {
      Random random(run);
      FeatureMemory memory;
      Vec3 p(0.0, 0.0, 0.05), going = Vec3::Zero();
      SurfacePoint before = surface_point(solid.shape, Side::outside, p, memory);
      const double speed = run % 2 == 0 ? 1e-2 : 1e-3;
      for (int n = 0; n < 4000; ++n) {
        going = 0.8 * going + random.vector(speed) - 0.1 * p;
        p += going;
        const SurfacePoint s = surface_point(solid.shape, Side::outside, p, memory);
        ASSERT_LE(s.depth, before.depth + going.norm() * (1.0 + 1e-9) + 1e-12)
            << solid.name << " run " << run << " step " << n;
        if (s.depth > 0.0) {
          ASSERT_NEAR((s.point - p).norm(), s.depth, 1e-9);
        }
        before = s;
        touched += s.depth > 0.0;
      }
    }
    EXPECT_GT(touched, 500) << solid.name;
  }
}

/// A scene that finds its objects by a tree must give an equal result for balls and points.
TEST(ProxySide, InScenesLargeAndSmallForPointsAndBalls) {
  for (const int others : {0, 40})
    for (const double radius : {0.0, 0.003}) {
      std::vector<Object> objects = {
          object("plate", Box{Vec3(0.05, 0.05, 5e-4)}, {.stiffness = 1.0})};
      for (int i = 0; i < others; ++i)
        objects.push_back(object(("o" + std::to_string(i)).c_str(), Sphere{0.01}, {},
                                 Vec3(1.0 + 0.1 * i, 0.0, 0.0)));
      Scene scene("s", objects);
      scene.set_tools({{.radius = radius, .body = nullptr, .name = "tool"}});
      TouchMemory memory = scene.memory();
      for (const double z : {0.2, 0.0123, -0.0077, -0.3, -0.31, -0.0077, 0.0123, -0.0077}) {
        const Command felt = scene.touch({{0.01, 0.02, z}, Vec3::Zero()}, memory);
        const Vec3 held(0.0, 0.0, std::max(0.0, 5e-4 + radius - z));
        EXPECT_LT((felt.elastic - held).norm(), 1e-12) << others << " " << radius << " " << z;
      }
    }
}

/// A plate of 1 mm meets the hand at up to 20 m/s. The plate must move the hand along.
TEST(ProxySide, AThinPlateThatMovesNeverPassesAHand) {
  for (const double speed : {0.0, 2.0, -10.0})
    for (const double beside : {0.0, 0.03, 0.0495}) {  // [m] The plate ends at 0.05.
      const Vec3 begin(0, 0, -0.5);
      const Scene scene =
          moving({object("plate", Box{Vec3(0.05, 0.05, 5e-4)}, {.stiffness = 1.0}, begin)}, {0},
                 {body("plate", 0.3, begin)}, {.gravity = Vec3(0, 0, 200.0)});
      World world(scene);
      Hand hand(world);
      int felt = 0;
      for (int n = 0; n < 120; ++n) {
        const Vec3 place(beside, 0.7 * beside, std::max(-0.3, 0.05 + speed * kDefaultTick * n));
        const double above = place.z() - world.objects()[0].pose.position.z();
        const double force = hand.touch(place).elastic.z();
        ASSERT_NEAR(force, std::max(0.0, 5e-4 - above), 1e-9) << speed << " " << n;
        world.step();
        felt += force > 0.0 ? 1 : 0;
      }
      EXPECT_GT(felt, 10) << speed << " " << beside;
    }
}

/// With a local model of the plate, the client's contact must hold the hand like the server's
/// contact.
TEST(ProxySide, HoldsInALocalModel) {
  const Scene scene("s", {object("plate", Box{Vec3(0.05, 0.05, 5e-4)}, {.stiffness = 1000.0})});
  for (const double first : {0.0015, 0.0045}) {
    const double heights[] = {first, first - 0.001, -0.0052, -0.0152, -0.002, 0.0001, first};
    test::expect_side_kept(scene, {0.01, 0.02, 0.0}, Vec3::UnitZ(), 5e-4, heights, -0.005);
  }
}

}  // namespace
}  // namespace feltwire::proxy_side_test
