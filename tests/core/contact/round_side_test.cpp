// The proxy of a round solid remembers its side. A hand that passes the middle must be pushed back
// to its side. A hand that moves around the solid must slide.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "tests/core/model_side.hpp"
#include "tests/core/moving.hpp"
#include "tests/core/support.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::round_side_test {
namespace {

using test::object;
using test::Random;

constexpr double kRadius = 0.005;
const double kSteps[] = {1e-4, 1e-3, 1e-2};  // [m] per sample: 0.1, 1 and 10 m/s at 1 kHz

struct Approach {
  const char* name;
  Shape shape;
  Vec3 middle;  // [m] The hand passes through this point.
  Vec3 out;     // unit vector against the hand's direction
  double half;  // [m] from the middle to the surface
};

/// Returns an approach straight through the middle of a ball, or through the axis of another solid.
Approach approach(int n, Random& random) {
  const double angle = random.uniform(-M_PI, M_PI), along = random.uniform(-0.018, 0.018);
  const Vec3 across(std::cos(angle), std::sin(angle), 0.0);
  const double up = random.chance(0.5) ? 1.0 : -1.0;
  switch (n % 5) {
    case 0:
      return {"ball", Sphere{kRadius}, Vec3::Zero(), random.direction(), kRadius};
    case 1:
      return {"rod", Capsule{kRadius, 0.02}, along * Vec3::UnitZ(), across, kRadius};
    case 2:
      return {"pipe", Cylinder{kRadius, 0.02}, along * Vec3::UnitZ(), across, kRadius};
    case 3:
      return {"ring", Torus{0.02, kRadius}, 0.02 * across,
              std::cos(angle) * up * Vec3::UnitZ() + std::sin(angle) * across, kRadius};
    default:
      return {"end of a rod", Capsule{kRadius, 0.02}, Vec3::Zero(), up * Vec3::UnitZ(),
              0.02 + kRadius};
  }
}

TEST(RoundSide, AHandPressedThroughTheMiddleIsPushedBackAtAnyDepthAndSpeed) {
  for (const std::uint64_t seed : test::seeds(1, 1, 1)) {
    Random random(seed);
    for (int n = 0; n < test::rounds(4000); ++n) {
      const Approach a = approach(n, random);
      const double step = kSteps[n % 3];
      FeatureMemory memory;
      double height = a.half + 0.0123 + random.uniform(0.0, step);
      double nearest = 1.0;  // [m] least distance to the middle so far
      const auto check = [&] {
        nearest = std::min(nearest, std::abs(height));
        // Rounding may turn the normal by this angle, for positions of centimetres near the middle.
        // The stored angle of a ring adds 2^-32 turns.
        const double rounding = 2e-17 / nearest + 3e-9;
        const SurfacePoint s =
            surface_point(a.shape, Side::outside, a.middle + height * a.out, memory);
        const double depth = std::max(0.0, a.half - height);
        ASSERT_NEAR(s.depth, depth, 1e-12) << a.name << " " << n << " height " << height;
        if (depth > 0.0) {
          ASSERT_LT((s.normal - a.out).norm(), rounding) << a.name << " " << n << " " << height;
          ASSERT_LT((s.point - a.middle - a.half * a.out).norm(), 1e-10 + rounding)
              << a.name << " " << n;
        }
      };
      const double farthest = n % 100 < 3 ? -1.0 : -0.05;
      for (; height > farthest; height -= step) ASSERT_NO_FATAL_FAILURE(check());
      for (; height < a.half + 0.0123; height += step) ASSERT_NO_FATAL_FAILURE(check());
    }
  }
}

/// A real hand misses the middle slightly. After the hand has passed the middle, the proxy has
/// turned by some 30 degrees. The contact ends when the hand, seen from the proxy, is beside the
/// solid.
TEST(RoundSide, SoIsOneThatPassesTheMiddleByAFiftiethOfTheRadius) {
  for (const std::uint64_t seed : test::seeds(2, 1, 1)) {
    Random random(seed);
    for (int n = 0; n < 1000; ++n) {
      const Approach a = approach(n % 3, random);
      const Vec3 aside = (0.02 * kRadius) * a.out.cross(Vec3(0.3, 0.5, 0.8)).normalized();
      const double step = n % 2 == 0 ? 2e-5 : 1e-4;
      FeatureMemory memory;
      double before = 0.0;
      for (double height = 0.006; height > -1.4 * kRadius; height -= step) {
        const SurfacePoint s =
            surface_point(a.shape, Side::outside, a.middle + aside + height * a.out, memory);
        if (height > kRadius) continue;
        ASSERT_GE(s.depth, before) << a.name << " " << n << " " << height;
        before = s.depth;
        if (height < -0.5 * kRadius) {
          ASSERT_GT(s.normal.dot(a.out), 0.7) << a.name << " " << n << " " << height;
        }
      }
      // Beside the ball nothing must hold the hand.
      EXPECT_EQ(
          surface_point(a.shape, Side::outside, a.middle - 0.03 * a.out + 80.0 * aside, memory)
              .depth,
          0.0)
          << a.name;
    }
  }
}

/// Down to three quarters of the radius, the proxy must equal the nearest surface point bitwise, at
/// any speed of the hand around the solid.
TEST(RoundSide, AHandThatGoesRoundSlides) {
  for (const std::uint64_t seed : test::seeds(3, 1, 1)) {
    Random random(seed);
    for (int n = 0; n < 300; ++n) {
      const double turn = random.uniform(0.001, 1.0);
      const Vec3 axis = n % 3 == 0 ? random.direction() : Vec3::UnitZ();
      const Shape shape = n % 3 == 0   ? Shape(Sphere{kRadius})
                          : n % 3 == 1 ? Shape(Capsule{kRadius, 0.02})
                                       : Shape(Cylinder{kRadius, 0.02});
      const Vec3 start = axis.cross(random.direction()).normalized();
      const Vec3 other = axis.cross(start);
      FeatureMemory memory;
      surface_point(shape, Side::outside, 2.0 * kRadius * start, memory);
      for (int i = 0; i < 100; ++i) {
        // The chord between two positions is nearer to the middle than both ends.
        const double in = 0.25 / std::cos(0.5 * turn);
        const double distance = kRadius * random.uniform(in, 0.999);
        const double angle = i * turn;
        Vec3 p = distance * (std::cos(angle) * start + std::sin(angle) * other);
        if (n % 3 != 0) p.z() = 0.01 * std::sin(angle);
        const Vec3 core(0.0, 0.0, n % 3 == 0 ? 0.0 : p.z());
        const SurfacePoint s = surface_point(shape, Side::outside, p, memory);
        const Vec3 nearest = direction(Vec3(p - core));
        if (i == 0 || in * kRadius > distance * std::cos(0.5 * turn)) continue;
        ASSERT_LT((s.normal - nearest).norm(), 1e-9) << n << " " << i << " turn " << turn;
        ASSERT_NEAR(s.depth, kRadius - (p - core).norm(), 1e-12);
      }
    }
  }
}

/// On a random path through a solid, a hand must not get more work than it has done.
TEST(RoundSide, NoWayThroughASolidGivesEnergy) {
  for (const std::uint64_t seed : test::seeds(4, 1, 1)) {
    Random random(seed);
    for (int n = 0; n < 60; ++n) {
      const Shape shape = n % 3 == 0   ? Shape(Sphere{kRadius})
                          : n % 3 == 1 ? Shape(Capsule{kRadius, 0.004})
                                       : Shape(Cylinder{kRadius, 0.02});
      FeatureMemory memory;
      Vec3 p(0.0, 0.0, 0.03);
      if (n % 3 == 2) p = Vec3(0.03, 0.0, 0.0);
      const Vec3 home = p;
      surface_point(shape, Side::outside, p, memory);
      Vec3 force = Vec3::Zero();
      double work = 0.0, most = 0.0;  // [J] work by the hand, for a stiffness of 1
      const auto go = [&](const Vec3& to) {
        const int steps = 1 + static_cast<int>((to - p).norm() / 5e-6);
        const Vec3 way = (to - p) / steps;
        for (int i = 0; i < steps; ++i) {
          p += way;
          const SurfacePoint s = surface_point(shape, Side::outside, p, memory);
          const Vec3 now = s.depth * s.normal;
          work -= 0.5 * (force + now).dot(way);
          force = now;
          most = std::max(most, 0.5 * s.depth * s.depth);
        }
      };
      for (int leg = 0; leg < 12; ++leg)
        go(random.uniform(0.0, 1.5) * kRadius * random.direction());
      go(home + 10.0 * kRadius * random.direction());
      // The contact is still held.
      if (surface_point(shape, Side::outside, p, memory).depth > 0.0) continue;
      // Sampling can miss half a step's work at each end of a contact.
      EXPECT_GE(work, -2e-3 * most) << n << " seed " << seed;
    }
  }
}

/// A scene that finds its objects by a tree must give an equal result for balls and points.
TEST(RoundSide, InScenesLargeAndSmallForPointsAndBalls) {
  for (const int others : {0, 40})
    for (const double radius : {0.0, 0.003})
      for (const Shape& shape : {Shape(Sphere{kRadius}), Shape(Capsule{kRadius, 0.02})}) {
        std::vector<Object> objects = {object("it", shape, {.stiffness = 1.0})};
        for (int i = 0; i < others; ++i)
          objects.push_back(object(("o" + std::to_string(i)).c_str(), Sphere{0.01}, {},
                                   Vec3(1.0 + 0.1 * i, 0.0, 0.0)));
        Scene scene("s", objects);
        scene.set_tools({{.radius = radius, .body = nullptr, .name = "tool"}});
        TouchMemory memory = scene.memory();
        for (const double x : {0.2, 0.0123, -0.0077, -0.3, -0.31, -0.0077, 0.0123, -0.0077}) {
          const Command felt = scene.touch({{x, 0.0, 0.0}, Vec3::Zero()}, memory);
          const Vec3 held(std::max(0.0, kRadius + radius - x), 0.0, 0.0);
          EXPECT_LT((felt.elastic - held).norm(), 1e-12) << others << " " << radius << " " << x;
        }
      }
}

/// A ball meets the hand at up to 20 m/s. The ball must move the hand along.
TEST(RoundSide, ABallThatMovesNeverPassesAHand) {
  for (const double speed : {0.0, 2.0, -10.0}) {
    const Vec3 begin(0, 0, -0.5);
    const Scene scene =
        test::moving({object("ball", Sphere{kRadius}, {.stiffness = 1.0}, begin)}, {0},
                     {test::body("ball", 0.3, begin)}, {.gravity = Vec3(0, 0, 200)});
    World world(scene);
    test::Hand hand(world);
    int felt = 0;
    for (int n = 0; n < 120; ++n) {
      const Vec3 place(0, 0, std::max(-0.3, 0.05 + speed * kDefaultTick * n));
      const double above = place.z() - world.objects()[0].pose.position.z();
      const double force = hand.touch(place).elastic.z();
      ASSERT_NEAR(force, std::max(0.0, kRadius - above), 1e-9) << speed << " " << n;
      world.step();
      felt += force > 0.0 ? 1 : 0;
    }
    EXPECT_GT(felt, 10) << speed;
  }
}

/// With a local model of the solid, the client's contact must hold the hand like the server's
/// contact.
TEST(RoundSide, HoldsInALocalModel) {
  for (const Shape& shape :
       {Shape(Sphere{kRadius}), Shape(Capsule{kRadius, 0.02}), Shape(Cylinder{kRadius, 0.02})}) {
    const Scene scene("s", {object("it", shape, {.stiffness = 1000.0})});
    for (const double first : {0.0065, 0.0045}) {
      const double heights[] = {first, first - 0.001, -0.0022, -0.0152, -0.002, 0.0001, first};
      SCOPED_TRACE(shape.index());
      test::expect_side_kept(scene, Vec3::Zero(), Vec3::UnitX(), kRadius, heights, -0.002);
    }
  }
}

}  // namespace
}  // namespace feltwire::round_side_test
