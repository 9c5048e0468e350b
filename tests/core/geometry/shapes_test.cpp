#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/contact/surface_point.hpp"

namespace feltwire::shapes_test {
namespace {

double distance_to(const Mesh&, const Vec3&) { return 0.0; }  // Other tests cover meshes.

// Exact signed distances, independent of the tested code. Negative inside.
double distance_to(const Plane&, const Vec3& p) { return p.z(); }
double distance_to(const Sphere& s, const Vec3& p) { return p.norm() - s.radius; }
double distance_to(const Box& b, const Vec3& p) {
  const Vec3 d = p.cwiseAbs() - b.half_extents;
  return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
}
double distance_to(const Capsule& c, const Vec3& p) {
  const Vec3 d(p.x(), p.y(), p.z() - std::clamp(p.z(), -c.half_length, c.half_length));
  return d.norm() - c.radius;
}
double distance_to(const Cylinder& c, const Vec3& p) {
  const double side = std::hypot(p.x(), p.y()) - c.radius;
  const double end = std::abs(p.z()) - c.half_length;
  return std::hypot(std::max(side, 0.0), std::max(end, 0.0)) + std::min(std::max(side, end), 0.0);
}
/// Returns the distance of a point (across, up) from a segment.
double to_segment(Eigen::Vector2d p, Eigen::Vector2d a, Eigen::Vector2d b) {
  const double share = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - share * (b - a)).norm();
}
double distance_to(const Cone& c, const Vec3& p) {
  const Eigen::Vector2d at(std::hypot(p.x(), p.y()), p.z());
  const Eigen::Vector2d foot(0, -c.half_length), rim(c.radius, -c.half_length),
      tip(0, c.half_length);
  const double way = std::min(to_segment(at, foot, rim), to_segment(at, rim, tip));
  const bool under = at.x() < c.radius * (c.half_length - p.z()) / (2.0 * c.half_length);
  return under && p.z() > -c.half_length ? -way : way;
}
double distance_to(const Torus& t, const Vec3& p) {
  return std::hypot(std::hypot(p.x(), p.y()) - t.major_radius, p.z()) - t.minor_radius;
}
double distance_to(const Shape& shape, const Vec3& p) {
  return std::visit([&](const auto& s) { return distance_to(s, p); }, shape);
}

const std::vector<Shape> kShapes = {
    Plane{},           Sphere{0.5},        Box{Vec3(0.5, 0.3, 0.1)}, Capsule{0.3, 0.4},
    Capsule{0.4, 0.0}, Cylinder{0.4, 0.2}, Cylinder{0.1, 0.6},       Cone{0.4, 0.3},
    Cone{0.2, 0.6},    Cone{0.6, 0.1},     Torus{0.4, 0.2},          Torus{0.6, 0.05}};

Vec3 random_point(std::mt19937& random, double reach) {
  std::uniform_real_distribution<double> along(-reach, reach);
  return {along(random), along(random), along(random)};
}

SurfacePoint fresh(const Shape& shape, Side side, const Vec3& p) {
  FeatureMemory memory;
  return surface_point(shape, side, p, memory);
}

Shape scaled(const Shape& shape, double by) {
  return on_primitive(
      shape,
      [&](auto solid) {
        solid.lengths(solid, [&](const Length&, double& value) { value *= by; });
        return Shape(solid);
      },
      [&] { return shape; });  // Other tests cover the other shapes.
}

TEST(Shapes, FirstContactIsTheNearestSurfacePointFromEitherSide) {
  std::mt19937 random(1);
  for (const Shape& shape : kShapes) {
    for (const Side side : {Side::outside, Side::inside}) {
      const double sign = side == Side::outside ? 1.0 : -1.0;
      int touched = 0;
      for (int i = 0; i < 5000; ++i) {
        const Vec3 p = random_point(random, 0.8);
        const double distance = sign * distance_to(shape, p);
        const SurfacePoint s = fresh(shape, side, p);
        if (distance >= 0.0) {
          EXPECT_EQ(s.depth, 0.0);
          continue;
        }
        ++touched;
        EXPECT_NEAR(s.depth, -distance, 1e-15);
        EXPECT_NEAR((s.point - p).norm(), s.depth, 1e-15);
        EXPECT_NEAR(distance_to(shape, s.point), 0.0, 1e-15);
        EXPECT_NEAR(s.normal.norm(), 1.0, 1e-15);
        EXPECT_NEAR((p + s.depth * s.normal - s.point).norm(), 0.0, 1e-15);
        // Slightly farther along the normal nothing must hold the tool. The rim of a hollow cone is
        // sharper than a right angle, so the normal there leads along the wall.
        const double over = sign * distance_to(shape, s.point + 1e-6 * s.normal);
        const bool sharp = std::holds_alternative<Cone>(shape) && side == Side::inside;
        EXPECT_GT(over, sharp ? -1e-6 : 0.0);
      }
      EXPECT_GT(touched, 20) << "shape " << shape.index();
    }
  }
}

TEST(Shapes, HaveNoBuiltInLength) {
  std::mt19937 random(2);
  for (const double by : {std::ldexp(1.0, -40), std::ldexp(1.0, 40), std::ldexp(1.0, -600)}) {
    for (const Shape& shape : kShapes) {
      for (const Side side : {Side::outside, Side::inside}) {
        for (int i = 0; i < 500; ++i) {
          const Vec3 p = random_point(random, 0.8);
          const SurfacePoint plain = fresh(shape, side, p);
          const SurfacePoint s = fresh(scaled(shape, by), side, by * p);
          EXPECT_NEAR(s.depth / by, plain.depth, 1e-15);
          EXPECT_NEAR((s.point / by - plain.point).norm(), 0.0, 1e-15);
          EXPECT_NEAR((s.normal - plain.normal).norm(), 0.0, 1e-14);
        }
      }
    }
  }
}

TEST(Shapes, AFreePointClearsTheMemory) {
  for (const Shape& shape : kShapes) {
    FeatureMemory memory{.feature = 1, .normal = Vec3::UnitY()};
    EXPECT_EQ(surface_point(shape, Side::outside, Vec3(0, 0, 10), memory).depth, 0.0);
    EXPECT_EQ(memory.feature, 0);
    EXPECT_EQ(memory.normal, Vec3::UnitZ());
  }
}

TEST(Shapes, NotANumberIsFree) {
  const double nan = std::nan("");
  for (const Shape& shape : kShapes)
    for (const Side side : {Side::outside, Side::inside})
      for (const Vec3& p : {Vec3(nan, nan, nan), Vec3(0.01, 0.01, nan)})
        EXPECT_EQ(fresh(shape, side, p).depth, 0.0) << shape.index();
}

TEST(Shapes, PlaneFeltFromInsideIsThePlaneTurnedOver) {
  const SurfacePoint s = fresh(Plane{}, Side::inside, Vec3(1, 2, 0.25));
  EXPECT_EQ(s.normal, -Vec3::UnitZ());
  EXPECT_EQ(s.depth, 0.25);
  EXPECT_EQ(s.point, Vec3(1, 2, 0));
}

TEST(Shapes, CentreOfASphereKeepsTheLastNormal) {
  FeatureMemory memory;
  surface_point(Sphere{1.0}, Side::outside, Vec3(0.5, 0, 0), memory);
  const SurfacePoint s = surface_point(Sphere{1.0}, Side::outside, Vec3::Zero(), memory);
  EXPECT_EQ(s.normal, Vec3::UnitX());
  EXPECT_EQ(s.depth, 1.0);
  // The hand enters at the centre. Any direction of the force is valid, but one direction must
  // exist.
  EXPECT_DOUBLE_EQ(fresh(Sphere{1.0}, Side::outside, Vec3::Zero()).normal.norm(), 1.0);
}

TEST(Shapes, CapsuleAxisPushesAcross) {
  const Capsule capsule{0.5, 1.0};
  FeatureMemory memory;
  surface_point(capsule, Side::outside, Vec3(0, 0.25, 0.3), memory);
  const SurfacePoint s = surface_point(capsule, Side::outside, Vec3(0, 0, 0.3), memory);
  EXPECT_EQ(s.normal, Vec3::UnitY());
  EXPECT_EQ(s.point, Vec3(0, 0.5, 0.3));
  // The hand enters exactly at the centre, then at the end on the axis.
  EXPECT_EQ(fresh(capsule, Side::outside, Vec3::Zero()).normal.z(), 0.0);
  EXPECT_EQ(fresh(capsule, Side::outside, Vec3(0, 0, 1.0)).normal, Vec3::UnitZ());
  // A hand without history must be pushed sideways. A hand that came through the end must be pushed
  // back to the end, as in a cylinder.
  EXPECT_EQ(fresh(capsule, Side::outside, Vec3(0, 0, 0.9)).depth, 0.5);
  memory = {};
  surface_point(capsule, Side::outside, Vec3(0, 0, 2.0), memory);
  const SurfacePoint held = surface_point(capsule, Side::outside, Vec3(0, 0, 0.9), memory);
  EXPECT_DOUBLE_EQ(held.depth, 0.6);
  EXPECT_EQ(held.normal, Vec3::UnitZ());
}

TEST(Shapes, CapsuleWithoutLengthIsASphere) {
  std::mt19937 random(3);
  for (const Side side : {Side::outside, Side::inside}) {
    for (int i = 0; i < 1000; ++i) {
      const Vec3 p = random_point(random, 0.8);
      const SurfacePoint capsule = fresh(Capsule{0.5, 0.0}, side, p);
      const SurfacePoint sphere = fresh(Sphere{0.5}, side, p);
      EXPECT_EQ(capsule.depth, sphere.depth);
      EXPECT_EQ(capsule.normal, sphere.normal);
    }
  }
}

TEST(Shapes, ThinBoxDoesNotPopThrough) {
  const Box sheet{Vec3(1.0, 1.0, 0.001)};
  FeatureMemory memory;
  // The hand moves from above in steps of 0.1 mm to just above the lower face. The force must
  // always push the hand up.
  for (double z = 0.0009; z > -0.001; z -= 0.0001) {
    const SurfacePoint s = surface_point(sheet, Side::outside, Vec3(0.2, 0.3, z), memory);
    EXPECT_EQ(s.normal, Vec3::UnitZ());
    EXPECT_EQ(s.point, Vec3(0.2, 0.3, 0.001));
    EXPECT_DOUBLE_EQ(s.depth, 0.001 - z);
  }
  // Below the bottom, the solid must still hold the hand. The hand reaches the lower face only
  // around the edge.
  EXPECT_DOUBLE_EQ(surface_point(sheet, Side::outside, Vec3(0.2, 0.3, -0.0011), memory).depth,
                   0.0021);
  EXPECT_EQ(surface_point(sheet, Side::outside, Vec3(1.1, 0.3, -0.0011), memory).depth, 0.0);
  EXPECT_EQ(surface_point(sheet, Side::outside, Vec3(0.2, 0.3, -0.0011), memory).depth, 0.0);
  EXPECT_EQ(surface_point(sheet, Side::outside, Vec3(0.2, 0.3, -0.0009), memory).normal,
            -Vec3::UnitZ());
}

TEST(Shapes, BoxKeepsItsFaceUntilLeftOverTheEdge) {
  const Box box{Vec3(1, 1, 1)};
  FeatureMemory memory;
  const auto at = [&](double x, double z) {
    return surface_point(box, Side::outside, Vec3(x, 0, z), memory);
  };
  EXPECT_EQ(at(0.0, 0.9).normal, Vec3::UnitZ());
  EXPECT_EQ(at(0.99, 0.9).normal, Vec3::UnitZ());  // +x is now nearer.
  EXPECT_EQ(at(1.01, 0.9).depth, 0.0);             // The hand is beyond the edge.
  const SurfacePoint again = at(0.99, 0.9);        // The hand enters through the other face.
  EXPECT_EQ(again.normal, Vec3::UnitX());
  EXPECT_NEAR(again.depth, 0.01, 1e-15);
}

TEST(Shapes, BoxTakesTheNearestFaceWhenEnteredFast) {
  const Box box{Vec3(1, 2, 3)};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Vec3 p = Vec3::Zero();
      p[axis] = sign * (box.half_extents[axis] - 0.5);
      const SurfacePoint s = fresh(box, Side::outside, p);
      EXPECT_EQ(s.normal, Vec3(sign * Vec3::Unit(axis)));
      EXPECT_EQ(s.depth, 0.5);
    }
  }
}

TEST(Shapes, RoomHoldsTheProxyOnEdgeAndCorner) {
  const Box room{Vec3(1, 1, 1)};
  const SurfacePoint edge = fresh(room, Side::inside, Vec3(1.3, -1.4, 0.5));
  EXPECT_EQ(edge.point, Vec3(1, -1, 0.5));
  EXPECT_NEAR(edge.depth, 0.5, 1e-15);
  EXPECT_NEAR((edge.normal - Vec3(-0.6, 0.8, 0.0)).norm(), 0.0, 1e-15);
  const SurfacePoint corner = fresh(room, Side::inside, Vec3(-3, 3, -2));
  EXPECT_EQ(corner.point, Vec3(-1, 1, -1));
  EXPECT_DOUBLE_EQ(corner.depth, 3.0);
  EXPECT_NEAR((corner.normal - Vec3(2, -2, 1) / 3.0).norm(), 0.0, 1e-15);
}

TEST(Shapes, CylinderKeepsCapAndSide) {
  const Cylinder disc{1.0, 0.001};  // The hand enters a thin disc from the top.
  FeatureMemory memory;
  EXPECT_EQ(surface_point(disc, Side::outside, Vec3(0.5, 0, 0.0009), memory).normal, Vec3::UnitZ());
  EXPECT_EQ(surface_point(disc, Side::outside, Vec3(0.5, 0, -0.0009), memory).normal,
            Vec3::UnitZ());
  EXPECT_DOUBLE_EQ(surface_point(disc, Side::outside, Vec3(0.5, 0, -0.0011), memory).depth, 0.0021);
  EXPECT_EQ(surface_point(disc, Side::outside, Vec3(1.1, 0, -0.0011), memory).depth, 0.0);
  EXPECT_EQ(surface_point(disc, Side::outside, Vec3(0.5, 0, -0.0011), memory).depth, 0.0);
  EXPECT_EQ(surface_point(disc, Side::outside, Vec3(0.5, 0, -0.0009), memory).normal,
            -Vec3::UnitZ());

  const Cylinder rod{0.01, 1.0};  // The hand enters a thin rod from the side, down to its axis.
  memory = {};
  EXPECT_EQ(surface_point(rod, Side::outside, Vec3(0, -0.009, 0.2), memory).normal, -Vec3::UnitY());
  const SurfacePoint axis = surface_point(rod, Side::outside, Vec3(0, 0, 0.2), memory);
  EXPECT_EQ(axis.normal, -Vec3::UnitY());
  EXPECT_EQ(axis.point, Vec3(0, -0.01, 0.2));
  EXPECT_EQ(surface_point(rod, Side::outside, Vec3(0, -0.001, 0.9995), memory).normal,
            -Vec3::UnitY());  // The end is nearer, but the hand stays on the side.
  EXPECT_EQ(fresh(rod, Side::outside, Vec3::Zero()).normal.z(), 0.0);
}

TEST(Shapes, CanFeltFromInsideHoldsTheProxyInItsRim) {
  const SurfacePoint s = fresh(Cylinder{1.0, 2.0}, Side::inside, Vec3(0, 4, -6));
  EXPECT_EQ(s.point, Vec3(0, 1, -2));
  EXPECT_DOUBLE_EQ(s.depth, 5.0);
  EXPECT_NEAR((s.normal - Vec3(0, -0.6, 0.8)).norm(), 0.0, 1e-15);
}

}  // namespace
}  // namespace feltwire::shapes_test
