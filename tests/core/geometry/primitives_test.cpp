// The functions of every shape must agree with its signed distance, and the signed distance must
// agree with the surface. The test covers all shapes of the list.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "core/contact/ball.hpp"
#include "core/geometry/shapes.hpp"
#include "tests/core/support.hpp"

namespace feltwire::primitives_test {
namespace {

#ifdef FELTWIRE_SANITIZED
constexpr int kEach = 1, kWays = 3;  // Sanitizers make a run forty times as slow.
#else
constexpr int kEach = 6, kWays = 10;  // number of solids of each kind, and of paths through each
#endif

using test::Random;

/// Calls f with shapes of each kind and several proportions.
template <class Call>
void for_each_solid(Call f) {
  Random random(1);
  Primitives::for_each([&](auto solid) {
    if (!is_bounded(solid)) return;
    for (int n = 0; n < kEach; ++n) {
      double largest = 0.0;
      solid.lengths(solid, [&](const Length& length, double& value) {
        value = random.uniform(0.005, 0.05);
        if (std::isfinite(length.most)) value = random.uniform(0.2, 0.9) * length.most;
        largest = std::max(largest, value);
      });
      SCOPED_TRACE(std::string(solid.kName) + " " + std::to_string(n));
      f(solid, random);
    }
  });
}

Vec3 random_in(const Vec3& half, double grown, Random& random) {
  Vec3 p;
  for (Eigen::Index i = 0; i < 3; ++i) p[i] = random.uniform(-grown, grown) * half[i];
  return p;
}

TEST(Primitives, HaveNamesOfTheirOwn) {
  std::set<std::string> names;
  Primitives::for_each([&](const auto& shape) { EXPECT_TRUE(names.insert(shape.kName).second); });
  EXPECT_EQ(names.size(), std::variant_size_v<Primitives::And<>>);
}

/// The distances at two points must not differ by more than the points' separation. The distance
/// along the gradient must lead to the surface.
TEST(Primitives, ADistanceIsOne) {
  for_each_solid([](const auto& solid, Random& random) {
    for (int i = 0; i < 20000; ++i) {
      const Vec3 p = random_in(solid.half_box(), 1.5, random);
      const FieldPoint at = solid.signed_distance(p);
      const Vec3 q = p + random.uniform(0.0, 0.02) * random.direction();
      ASSERT_LE(std::abs(solid.signed_distance(q).distance - at.distance), (q - p).norm() + 1e-15);
      ASSERT_NEAR(at.gradient.norm(), 1.0, 1e-14);
      const Vec3 foot = p - at.distance * at.gradient;
      ASSERT_NEAR(solid.signed_distance(foot).distance, 0.0, 1e-15) << p.transpose();
    }
  });
}

/// A convex solid contains the midpoint of any two of its points. Other solids lack some midpoints.
TEST(Primitives, AreConvexIfTheySaySo) {
  for_each_solid([](const auto& solid, Random& random) {
    const auto point_within = [&] {
      for (;;) {
        const Vec3 p = random_in(solid.half_box(), 1.0, random);
        if (solid.signed_distance(p).distance < 0.0) return p;
      }
    };
    // [m] largest distance of the midpoints
    double most = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < 5000; ++i) {
      const Vec3 middle = 0.5 * (point_within() + point_within());
      most = std::max(most, solid.signed_distance(middle).distance);
    }
    EXPECT_EQ(most < 0.0, solid.kConvex);
  });
}

TEST(Primitives, AProxyThatKnowsNothingStandsOnTheNearestSurface) {
  for_each_solid([](const auto& solid, Random& random) {
    for (const Side side : {Side::outside, Side::inside})
      for (int i = 0; i < 5000; ++i) {
        const Vec3 p = random_in(solid.half_box(), 1.3, random);
        const double sign = side == Side::outside ? 1.0 : -1.0;
        const FieldPoint at = solid.signed_distance(p);
        FeatureMemory memory;
        const SurfacePoint s = solid.surface_point(side, p, memory);
        ASSERT_NEAR(s.depth, std::max(0.0, -sign * at.distance), 1e-15) << p.transpose();
        if (!(s.depth > 1e-9)) continue;
        ASSERT_LT((s.point - p - s.depth * s.normal).norm(), 1e-12);
        ASSERT_LT((s.normal - sign * at.gradient).norm(), 1e-9) << p.transpose();
      }
  });
}

TEST(Primitives, BoxAndBallHoldTheSolidAndTouchIt) {
  for_each_solid([](const auto& solid, Random& random) {
    const Vec3 half = solid.half_box();
    for (int i = 0; i < 20000; ++i) {
      const Vec3 p = random_in(half, 2.0, random);
      if (!(solid.signed_distance(p).distance < 0.0)) continue;
      ASSERT_TRUE((p.cwiseAbs().array() <= half.array()).all());
      ASSERT_LE(p.norm(), solid.reach());
    }
    Vec3 most = Vec3::Zero();
    double farthest = 0.0;
    for (const Vec3& v : solid.triangles(256).vertices) {
      most = most.cwiseMax(v.cwiseAbs());
      farthest = std::max(farthest, v.norm());
    }
    EXPECT_LT((most - half).norm(), 1e-12);
    EXPECT_NEAR(farthest, solid.reach(), 1e-12);
  });
}

/// The reference is a sum over small cubes.
TEST(Primitives, MassIsThatOfTheSolid) {
  constexpr int kCells = 80;
  for_each_solid([](const auto& solid, Random&) {
    const Vec3 half = solid.half_box(), cell = 2.0 / kCells * half;
    double volume = 0.0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (int x = 0; x < kCells; ++x)
      for (int y = 0; y < kCells; ++y)
        for (int z = 0; z < kCells; ++z) {
          const Vec3 p = Vec3(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(cell) - half;
          if (!(solid.signed_distance(p).distance < 0.0)) continue;
          volume += cell.prod();
          first += cell.prod() * p;
          second += cell.prod() * p * p.transpose();
        }
    const MassProperties mass = solid.mass_properties();
    EXPECT_NEAR(mass.volume, volume, 5e-3 * volume);
    EXPECT_LT((mass.center - first / volume).norm(), 5e-3 * half.norm());
    second -= first * first.transpose() / volume;
    const Mat3 inertia = second.trace() * Mat3::Identity() - second;
    EXPECT_LT((mass.inertia - inertia).norm(), 1e-2 * inertia.norm());
  });
}

/// The triangles must be closed, point outwards, lie on the surface, and enclose nearly the
/// complete volume.
TEST(Primitives, TrianglesAreTheSurface) {
  for_each_solid([](const auto& solid, Random&) {
    const TriangleSoup soup = solid.triangles(192);
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    double volume = 0.0;
    for (const Triangle& t : soup.triangles) {
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_TRUE(edges.emplace(t[k], t[(k + 1) % 3]).second) << "an edge twice the same way";
      volume += soup.vertices[t[0]].dot(soup.vertices[t[1]].cross(soup.vertices[t[2]])) / 6.0;
    }
    for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a})) << "an open edge";
    for (const Vec3& v : soup.vertices) ASSERT_NEAR(solid.signed_distance(v).distance, 0.0, 1e-15);
    const double whole = solid.mass_properties().volume;
    EXPECT_NEAR(volume, whole, 1.5e-3 * whole);
    EXPECT_LE(volume, whole * (1.0 + 1e-12));
  });
}

TEST(Primitives, TheLargestBallWithinHasTheRadiusOfTheRoom) {
  for_each_solid([](const auto& solid, Random& random) {
    double deepest = 0.0;
    Vec3 best = Vec3::Zero();
    for (int i = 0; i < 40000; ++i) {
      const double near = i < 5000 ? 1.0 : 0.02;
      const Vec3 p =
          (i < 5000 ? Vec3(Vec3::Zero()) : best) + random_in(solid.half_box(), near, random);
      const double depth = -solid.signed_distance(p).distance;
      ASSERT_LE(depth, solid.room() * (1.0 + 1e-12));
      if (depth > deepest) deepest = depth, best = p;
    }
    EXPECT_GT(deepest, 0.98 * solid.room());
  });
}

/// A ball's depth must equal the depth of its surface in the solid, on both sides.
TEST(Primitives, ABallIsAPointThatIsThick) {
  for_each_solid([](const auto& solid, Random& random) {
    const double radius = 0.3 * solid.room();
    for (int i = 0; i < 5000; ++i) {
      const Vec3 p = random_in(solid.half_box(), 1.4, random);
      const FieldPoint at = solid.signed_distance(p);
      FeatureMemory memory;
      const SurfacePoint out = ball_surface(solid, Side::outside, p, radius, memory);
      ASSERT_EQ(out.depth > 0.0, at.distance < radius) << p.transpose();
      if (out.depth > 1e-9) {
        // The ball rests on the surface, or on the rim of a hole that is too small.
        ASSERT_GE(out.depth, radius - at.distance - 1e-15);
        ASSERT_LT((out.point - p - out.depth * out.normal).norm(), 1e-12);
        if (at.distance > 0.0) {
          ASSERT_NEAR(solid.signed_distance(out.point).distance, radius, 1e-12);
        }
        if (out.depth < radius - at.distance + 1e-12) {
          ASSERT_LT((out.normal - at.gradient).norm(), 1e-9);
        }
      }
      // In a hollow the ball rests in edges and corners. The ball's depth is at least the depth at
      // the nearest surface. The depth is zero exactly when the ball touches nothing.
      memory = {};
      const SurfacePoint in = ball_surface(solid, Side::inside, p, radius, memory);
      ASSERT_GE(in.depth, std::max(0.0, radius + at.distance) - 1e-15);
      ASSERT_EQ(in.depth > 0.0, radius + at.distance > 0.0) << p.transpose();
      if (!(in.depth > 0.0)) continue;
      ASSERT_NEAR(solid.signed_distance(in.point).distance, -radius, 1e-12);
    }
  });
}

/// Returns the distance [m] from a geom to a point.
double distance_to(const PhysicsGeom& geom, const Vec3& p) {
  const Pose pose = geom.pose.value_or(Pose{});
  const Vec3 own = pose.orientation.conjugate() * (p - pose.position);
  switch (geom.kind) {
    case PhysicsGeom::Kind::sphere:
      return Sphere{geom.size.x()}.signed_distance(own).distance;
    case PhysicsGeom::Kind::box:
      return Box{geom.size}.signed_distance(own).distance;
    case PhysicsGeom::Kind::capsule:
      return Capsule{geom.size.x(), geom.size.y()}.signed_distance(own).distance;
    case PhysicsGeom::Kind::cylinder:
      return Cylinder{geom.size.x(), geom.size.y()}.signed_distance(own).distance;
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

/// The geoms must match the solid within the documented error of at most half a percent.
TEST(Primitives, GeomsStandForTheSolid) {
  for_each_solid([](const auto& solid, Random&) {
    const auto geoms = solid.geoms(Side::outside);
    ASSERT_FALSE(geoms.empty());
    const double error = geoms.size() > 1 ? 0.005 * solid.reach() : 1e-12;
    for (const Vec3& v : solid.triangles(90).vertices) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const PhysicsGeom& geom : geoms) {
        if (geom.kind != PhysicsGeom::Kind::hull) {
          nearest = std::min(nearest, distance_to(geom, v));
          continue;
        }
        // The hull's corners must lie on the solid, and extend as far as the solid in each
        // direction.
        Vec3 most = Vec3::Zero();
        for (const Vec3& corner : geom.hull) {
          EXPECT_NEAR(solid.signed_distance(corner).distance, 0.0, 1e-12);
          most = most.cwiseMax(corner.cwiseAbs());
        }
        EXPECT_LT((most - solid.half_box()).norm(), 1e-12);
        return;
      }
      ASSERT_NEAR(nearest, 0.0, error);
    }
  });
}

/// A hand moves back and forth through the solid in steps longer than the thickness. The proxy must
/// never be ahead of the hand. A hand that entered must be held or move around the solid.
TEST(Primitives, NothingIsPassedStraightThrough) {
  for_each_solid([](const auto& solid, Random& random) {
    int met = 0;
    for (int run = 0; run < 400; ++run) {
      // The hand passes through a point deep in the solid, perpendicular to the surface.
      Vec3 deep = random_in(solid.half_box(), 1.0, random);
      const FieldPoint at = solid.signed_distance(deep);
      if (!(at.distance < 0.0)) continue;
      ++met;
      const Vec3 out = at.gradient;
      const double step = (run % 3 == 0 ? 3.0 : run % 3 == 1 ? 0.3 : 0.03) * solid.room();
      FeatureMemory memory;
      double height = -at.distance + 0.05 * solid.room(), before = 0.0;
      for (; height > -2.0 * solid.room(); height -= step) {
        const SurfacePoint s = solid.surface_point(Side::outside, deep + height * out, memory);
        ASSERT_GE(s.depth, before - 1e-9) << run << " height " << height << " step " << step;
        if (height < -at.distance) {
          ASSERT_GT(s.depth, 0.0) << run << " height " << height << " step " << step;
          ASSERT_GT(s.normal.dot(out), 0.0) << run;
        }
        before = s.depth;
      }
    }
    EXPECT_GT(met, 50);
  });
}

/// A hand moves to and fro at random. The force must not grow faster than the hand's movement
/// allows.
TEST(Primitives, NoForceRisesFasterThanTheHandMoves) {
  for_each_solid([](const auto& solid, Random& random) {
    int touched = 0;
    for (int run = 0; run < 20; ++run) {
      FeatureMemory memory;
      Vec3 p = 2.0 * solid.reach() * random.direction(), going = Vec3::Zero();
      SurfacePoint before = solid.surface_point(Side::outside, p, memory);
      const double speed = run % 2 == 0 ? 1e-2 : 1e-3;
      for (int n = 0; n < 3000; ++n) {
        going = 0.8 * going + speed * random.direction() - 0.1 * p;
        p += going;
        const SurfacePoint s = solid.surface_point(Side::outside, p, memory);
        ASSERT_LE(s.depth, before.depth + going.norm() * (1.0 + 1e-9) + 1e-12)
            << "run " << run << " step " << n;
        if (s.depth > 0.0) {
          ASSERT_NEAR((s.point - p).norm(), s.depth, 1e-9);
          ASSERT_NEAR(solid.signed_distance(s.point).distance, 0.0, 1e-7);
        }
        before = s;
        touched += s.depth > 0.0;
      }
    }
    EXPECT_GT(touched, 200);
  });
}

/// On a random path through a solid, a hand must not get more work than it has done.
TEST(Primitives, NoWayThroughASolidGivesEnergy) {
  for_each_solid([](const auto& solid, Random& random) {
    for (int run = 0; run < kWays; ++run) {
      FeatureMemory memory;
      Vec3 p = 2.0 * solid.reach() * random.direction(), force = Vec3::Zero();
      solid.surface_point(Side::outside, p, memory);
      double work = 0.0, most = 0.0;  // [J] work by the hand, for a stiffness of 1
      const auto go = [&](const Vec3& to) {
        const int steps = 1 + static_cast<int>((to - p).norm() / 5e-6);
        const Vec3 way = (to - p) / steps;
        for (int i = 0; i < steps; ++i) {
          p += way;
          const SurfacePoint s = solid.surface_point(Side::outside, p, memory);
          const Vec3 now = s.depth * s.normal;
          work -= 0.5 * (force + now).dot(way);
          force = now;
          most = std::max(most, 0.5 * s.depth * s.depth);
        }
      };
      for (int leg = 0; leg < 12; ++leg)
        go(random.uniform(0.0, 1.5) * solid.reach() * random.direction());
      go(20.0 * solid.reach() * random.direction());
      // The contact is still held.
      if (solid.surface_point(Side::outside, p, memory).depth > 0.0) continue;
      // Sampling can miss half a step's work at each end of a contact.
      EXPECT_GE(work, -2e-3 * most) << run;
    }
  });
}

/// When a hand passes the axis of a ring, the nearest part of the ring changes at once. The proxy
/// must stay.
TEST(Ring, HoldsAHandThatIsPressedThroughItsHole) {
  const Torus ring{0.03, 0.004};
  Random random(2);
  for (int run = 0; run < 300; ++run) {
    const double angle = random.uniform(-M_PI, M_PI), step = run % 2 == 0 ? 1e-2 : 1e-4;
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
    FeatureMemory memory;
    double before = 0.0;
    for (double x = 0.035 + random.uniform(0.0, step); x > -0.06; x -= step) {
      const Vec3 p = x * out + 1e-5 * Vec3::UnitZ().cross(out);  // slightly beside the axis
      const SurfacePoint s = ring.surface_point(Side::outside, p, memory);
      ASSERT_GE(s.depth, before) << run << " at " << x;
      if (x > 0.034) continue;
      ASSERT_NEAR(s.depth, 0.034 - x, 3e-4) << run << " at " << x;
      ASSERT_GT(s.normal.dot(out), 0.99) << run << " at " << x;
      before = s.depth;
    }
    // Above the ring nothing must hold the hand.
    ASSERT_EQ(ring.surface_point(Side::outside, Vec3(0.0, 0.0, 0.01), memory).depth, 0.0);
  }
}

/// A hand that moves over the blunt tip of a cone must continue on the other side.
TEST(Cone, LetsAHandSlideOverABluntTip) {
  const Cone hat{0.05, 0.005};
  FeatureMemory memory;
  hat.surface_point(Side::outside, Vec3(0.04, 0.001, 0.02), memory);
  for (double x = 0.04; x > -0.04; x -= 1e-4) {
    const Vec3 p(x, 1e-5, 0.005 - 0.2 * std::abs(x) - 2e-4);
    const SurfacePoint s = hat.surface_point(Side::outside, p, memory);
    ASSERT_GT(s.depth, 1e-4) << x;
    ASSERT_LT(s.depth, 5e-4) << x;
    if (std::abs(x) > 0.005) {
      ASSERT_NEAR(s.depth, -hat.signed_distance(p).distance, 1e-12) << x;
    }
  }
}

}  // namespace
}  // namespace feltwire::primitives_test
