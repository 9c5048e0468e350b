// Compares convex decomposition with closed forms. The parts must cover the mesh, and must extend
// outside by the tolerance at most.

#include "core/convex/decomposition.hpp"

#include <gtest/gtest.h>

#include "core/convex/clipped_solid.hpp"
#include "core/mesh/mesh_distance.hpp"
#include "tests/core/support.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::decomposition_test {
namespace {

using test::Random;

double volume_of(const ConvexParts& parts) {
  double sum = 0.0;
  for (const auto& part : parts.parts) sum += convex_hull(part)->volume;
  return sum;
}

/// A prism from z = 0 to `high`. `rim` is counter-clockwise, and `flat` holds its triangles.
TriangleSoup prism(const std::vector<std::pair<double, double>>& rim,
                   const std::vector<Triangle>& flat, double high) {
  TriangleSoup s;
  const auto count = static_cast<std::uint32_t>(rim.size());
  for (const double z : {0.0, high})
    for (const auto& [x, y] : rim) s.vertices.emplace_back(x, y, z);
  for (const auto& [a, b, c] : flat) {
    s.triangles.push_back({a, c, b});
    s.triangles.push_back({a + count, b + count, c + count});
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = (i + 1) % count;
    s.triangles.push_back({i, k, k + count});
    s.triangles.push_back({i, k + count, i + count});
  }
  return s;
}

/// An L of three unit squares with height one.
TriangleSoup l_shape() {
  return prism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
               {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 1.0);
}

TEST(ConvexHull, OfABoxIsTheBoxAndFlatPointsHaveNone) {
  const TriangleSoup box = test::box(Vec3(1, 2, 3), 3);
  const auto hull = convex_hull(box.vertices);
  ASSERT_TRUE(hull);
  EXPECT_EQ(hull->vertices.size(), 8u);
  EXPECT_NEAR(hull->volume, 48.0, 1e-12);
  EXPECT_TRUE(hull->contains(Vec3(0.9, 1.9, 2.9)));
  EXPECT_FALSE(hull->contains(Vec3(1.1, 0, 0)));
  EXPECT_FALSE(convex_hull(test::sheet(1.0, 3).vertices));
  // Qhull reports a different error for these points, because all share a coordinate.
  const std::vector<Vec3> same = {{2, 0, 0}, {2, 1, 0}, {2, 0, 1}, {2, 1, 1}, {2, 0.5, 0.3}};
  EXPECT_FALSE(convex_hull(same));
  EXPECT_FALSE(convex_hull(std::vector<Vec3>(5, Vec3::Ones())));
}

// Three cuts through a box meet in a corner inside, on no triangle.
TEST(ClippedSolid, HasTheCornersOfItsPlanesInTheSolid) {
  const MeshSurface box(TriangleMesh(test::box(Vec3(1, 2, 3))));
  const HalfSpaceBelow x{Vec3::UnitX(), 0.5}, y{Vec3::UnitY(), 0.25}, z{-Vec3::UnitZ(), 1.0};
  const ClippedSolid part = ClippedSolid(box).below(x).below(y);
  EXPECT_NEAR(convex_hull(part.points())->volume, 1.5 * 2.25 * 6.0, 1e-12);
  const auto sides = part.points_beside(z);
  EXPECT_NEAR(convex_hull(sides.first)->volume, 1.5 * 2.25 * 4.0, 1e-12);
  EXPECT_NEAR(convex_hull(sides.second)->volume, 1.5 * 2.25 * 2.0, 1e-12);
  EXPECT_NEAR(convex_hull(part.below(z).points())->volume, 1.5 * 2.25 * 4.0, 1e-12);
}

TEST(Decomposition, ABoxIsOnePartAndAnLIsTwoExactly) {
  const MeshSurface box(TriangleMesh(test::box(Vec3(0.1, 0.2, 0.3), 2)));
  EXPECT_EQ(convex_parts(box, {}).parts.size(), 1u);
  const MeshSurface l{TriangleMesh(l_shape())};
  ASSERT_TRUE(l.mesh().report().closed());
  const ConvexParts parts = convex_parts(l, {});
  EXPECT_EQ(parts.parts.size(), 2u);
  EXPECT_NEAR(volume_of(parts), 3.0, 1e-9);
  EXPECT_LE(parts.outside, 1e-6);
}

// The parts must cover the complete solid. No part may extend beyond the tolerance.
TEST(Decomposition, PartsCoverARingAndLeaveItsHoleOpen) {
  const MeshSurface ring(TriangleMesh(test::torus(0.05, 0.01, 48, 16)));
  const DecompositionOptions options{.tolerance = 0.003};
  const ConvexParts parts = convex_parts(ring, options);
  EXPECT_GT(parts.parts.size(), 3u);
  EXPECT_LE(parts.parts.size(), options.most);
  EXPECT_LE(parts.outside, 0.003);
  const Solid solid = solid_of(TriangleMesh(test::torus(0.05, 0.01, 48, 16)));
  std::vector<ConvexHull> hulls;
  for (const auto& part : parts.parts) {
    hulls.push_back(*convex_hull(part));
    // In a convex part, every point is a corner.
    EXPECT_EQ(hulls.back().vertices.size(), part.size());
  }
  Random random(1);
  int inside = 0, covered = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(random.uniform(-0.06, 0.06), random.uniform(-0.06, 0.06),
                 random.uniform(-0.01, 0.01));
    const double distance = solid.distance(p);
    bool in_a_part = false;
    for (const ConvexHull& hull : hulls) in_a_part = in_a_part || hull.contains(p, 1e-9);
    if (distance < -1e-8) {
      EXPECT_TRUE(in_a_part) << p.transpose();
    }
    if (in_a_part) {
      EXPECT_LE(distance, 0.003 + 1e-8) << p.transpose();
    }
    inside += distance < 0.0 ? 1 : 0;
    covered += in_a_part ? 1 : 0;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_LT(covered, 20000);
}

TEST(Decomposition, KeepsToTheNumberOfPartsAndSaysWhatThatCosts) {
  const MeshSurface ring(TriangleMesh(test::torus(0.05, 0.01, 48, 16)));
  for (const std::size_t most : {1u, 3u}) {
    const ConvexParts parts = convex_parts(ring, {.tolerance = 0.001, .most = most});
    EXPECT_LE(parts.parts.size(), most);
    EXPECT_GT(parts.outside, 0.001);
  }
  // The hull of the complete ring covers the centre of the hole, at 0.04 from the surface of the
  // tube.
  EXPECT_NEAR(convex_parts(ring, {.tolerance = 0.001, .most = 1}).outside, 0.04, 0.04 / 8);
}

// A small notch in the rim of a plate. Cuts along the plate are the most balanced, but do not
// reduce the error.
TEST(Decomposition, AThinPlateWithANotchIsNotCutIntoThinnerOnes) {
  const TriangleSoup plate =
      prism({{0, 0}, {60, 0}, {60, 20}, {9, 60}, {9, 57}, {5, 57}, {5, 60}, {0, 60}},
            {{0, 1, 5}, {1, 4, 5}, {1, 2, 4}, {2, 3, 4}, {0, 5, 6}, {0, 6, 7}}, 0.1);
  const MeshSurface surface{TriangleMesh(plate)};
  ASSERT_TRUE(surface.mesh().report().closed());
  const ConvexParts parts = convex_parts(surface, {.tolerance = 1.0});
  EXPECT_LE(parts.outside, 1.0);
  EXPECT_GE(parts.parts.size(), 2u);
  EXPECT_LE(parts.parts.size(), 8u);
  for (const auto& part : parts.parts) {
    const auto [least, most] =
        std::ranges::minmax_element(part, {}, [](const Vec3& p) { return p.z(); });
    EXPECT_NEAR(most->z() - least->z(), 0.1, 1e-9);
  }
}

TEST(Decomposition, IsTheSameTwice) {
  const MeshSurface ring(TriangleMesh(test::torus(0.05, 0.01, 24, 12)));
  EXPECT_EQ(convex_parts(ring, {}).parts, convex_parts(ring, {}).parts);
}

}  // namespace
}  // namespace feltwire::decomposition_test
