// Tests each limit of the valid radius of a fitted surface separately.

#include <gtest/gtest.h>

#include <cmath>

#include "core/grid/distance_grid.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"
#include "core/local_model_extraction/mesh_fit.hpp"
#include "tests/core/support.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::fit_claims_test {
namespace {

using test::Random;

// A cylinder's normal rotates by k across the axis and by zero along it. A ball's normal rotates
// equally in both directions.
TEST(LocalCurvature, IsTheCylinderOrTheBallThatTheNormalTurnsAbout) {
  Random random(1);
  for (int n = 0; n < 100; ++n) {
    const Vec3 normal = random.direction();
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    const double turn = random.uniform(-3.0, 3.0), k = random.decades(0.0, 2.0);
    const Vec3 across = std::cos(turn) * u + std::sin(turn) * v;
    const double cu = across.dot(u), cv = across.dot(v);
    const LocalCurvature rod = local_curvature(u, v, k * cu * cu, k * cu * cv, k * cv * cv);
    EXPECT_NEAR(rod.curvature, k, 1e-9 * std::abs(k));
    EXPECT_NEAR(std::abs(rod.axis.dot(normal.cross(across))), 1.0, 1e-9);
    const LocalCurvature ball = local_curvature(u, v, k, 0.0, k);
    EXPECT_NEAR(ball.curvature, k, 1e-9 * std::abs(k));
    EXPECT_TRUE(ball.axis.isZero(0.0));
    // The first curvatures are nearer to a ball than to a cylinder: the smaller is three quarters
    // of the larger. The second are nearer to a cylinder: the smaller is a tenth.
    EXPECT_NEAR(local_curvature(u, v, k, 0.0, 0.75 * k).curvature, 0.875 * k, 1e-9 * std::abs(k));
    EXPECT_NEAR(local_curvature(u, v, k, 0.0, 0.1 * k).curvature, k, 1e-9 * std::abs(k));
  }
}

LocalModel model_at(const Object& object, const Vec3& position, const Vec3& from) {
  const Scene scene("s", {object});
  TouchMemory memory = scene.memory();
  scene.touch({from, Vec3::Zero()}, memory);
  scene.touch({position, Vec3::Zero()}, memory);
  return local_model(scene, position, memory);
}

MeshFit plane_of(const MeshSurface& surface, const Vec3& place) {
  MeshFit fit;
  const auto nearest = surface.nearest(place, 1.0);
  fit.point = nearest.point;
  fit.triangle = nearest.triangle;
  fit.normal = triangle_normal(surface.mesh().corners(nearest.triangle));
  return fit;
}

// A ball deviates from its tangent plane by x^2 / 2R. At a distance of R / 32 the deviation is x /
// 64. A hollow ball deviates by an equal amount.
TEST(MeshFits, APlaneOnABallEndsWhereTheSlopeDoes) {
  constexpr double kRadius = 0.05;
  const MeshSurface surface(TriangleMesh(test::icosphere(kRadius, 6)));
  const Vec3 top = kRadius * Vec3(0.2, 0.3, 0.93).normalized();
  for (const double side : {1.0, -1.0}) {
    MeshFits fits(surface, side);
    MeshFit fit = plane_of(surface, top);
    fit.normal = side * top.normalized();
    fits.add(fit);
    const auto other = fits.first_other(top, 0.0, 0.01);
    EXPECT_NE(other.triangle, TriangleMesh::kNone);
    EXPECT_NEAR(other.distance, kRadius / 32.0, 1e-3);  // A facet is 0.9 mm wide.
  }
}

// The facets are so fine that the inspected facets are almost flat. The fit must still be a ball.
TEST(MeshFits, AVeryFineBallIsABallAllTheSame) {
  constexpr double kRadius = 0.09;
  const Vec3 out = Vec3(0.2, 0.3, 0.93).normalized();
  const TriangleSoup cap = [&] {  // the part near `out`, four times as fine
    TriangleSoup soup;
    const Vec3 u = out.unitOrthogonal(), v = out.cross(u);
    constexpr int kSide = 120;
    constexpr double kStep = 3e-4;  // [m]
    for (int i = 0; i <= kSide; ++i)
      for (int j = 0; j <= kSide; ++j)
        soup.vertices.push_back(
            kRadius *
            (kRadius * out + kStep * ((i - kSide / 2) * u + (j - kSide / 2) * v)).normalized());
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (kSide + 1) + j); };
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    return soup;
  }();
  const Vec3 over = (kRadius + 2e-4) * out;
  const LocalModel model = model_at(test::mesh_object(cap), over, 1.1 * over);
  ASSERT_EQ(model.count, 1);
  EXPECT_NEAR(model.patches[0].curvature, 1.0 / kRadius, 0.05 / kRadius);
  EXPECT_GT(model.reach, 6e-3);
}

// The other side of a sheet must not belong to a patch, for any thickness.
TEST(MeshFits, WhatIsTurnedAwayIsNotDescribed) {
  const Vec3 half(0.02, 0.02, 1e-6);
  MeshSurface surface(TriangleMesh(test::box(half, 4)));
  MeshFits fits(surface, 1.0);
  fits.add(plane_of(surface, Vec3(1e-3, 2e-3, half.z())));
  EXPECT_LT(fits.first_other(Vec3(1e-3, 2e-3, half.z()), 0.0, 0.01).distance, 1e-4);
}

// The hollow hides the corners and the centroid of a triangle, but not the middle of the triangle's
// longest side.
TEST(MeshFits, ATriangleAcrossAHollowIsNotHidden) {
  constexpr double kHollow = 0.05, kReach = 0.02, kAbove = 2e-4;
  TriangleSoup soup;
  soup.vertices = {{-kReach, 0, kAbove}, {kReach, 0, kAbove}, {0, kReach, kAbove}};
  soup.triangles.push_back({0, 1, 2});
  const MeshSurface surface{TriangleMesh(soup)};
  MeshFits fits(surface, 1.0);
  MeshFit fit;
  fit.point = -surface.mesh().origin();  // the lowest point of the hollow
  fit.curvature = -1.0 / kHollow;
  fits.add(fit);
  EXPECT_EQ(fits.first_other(fit.point, 0.0, 0.03).triangle, 0u);
}

LocalModel model_over(const TriangleSoup& soup, const Vec3& position,
                      const MeshOptions& options = {}) {
  return model_at(test::mesh_object(soup, options), position, position + 1e-3 * Vec3::UnitZ());
}

// Two blocks are side by side. Two planes beyond the gap do not belong to the first block: a plane
// at equal height, and a lower plane that only the top hides.
TEST(MeshFits, WhatAnotherPatchCutsOffIsNotDescribed) {
  const Vec3 half(0.02, 0.02, 0.02);
  for (const double lower : {0.0, 5e-3}) {
    const LocalModel model = model_over(
        test::joined(test::box(half), test::moved(test::box(half), Vec3(0.045, 0, -lower))),
        Vec3(0.019, 0.003, 0.0205));
    ASSERT_GE(model.count, 2);
    // The gap of 5 mm begins 1 mm away.
    EXPECT_NEAR(model.reach, std::hypot(6e-3, lower > 0.0 ? lower + 5e-4 : 5e-4), 1e-4);
  }
}

/// Adds a square with a corner and two sides. Its outside is along u x v.
void add_square(TriangleSoup& soup, const Vec3& corner, const Vec3& u, const Vec3& v) {
  const auto first = static_cast<std::uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), {corner, corner + u, corner + u + v, corner + v});
  soup.triangles.push_back({first, first + 1, first + 2});
  soup.triangles.push_back({first, first + 2, first + 3});
}

// At the foot of a block's edge, two concave edges meet a convex one.
TEST(MeshFits, ConvexAndHollowEdgesAreNotTogether) {
  const double s = 0.03;
  const Vec3 x = s * Vec3::UnitX(), y = s * Vec3::UnitY(), z = s * Vec3::UnitZ();
  TriangleSoup soup;  // The block stands on x < 0, y < 0.
  for (const Vec3& corner : {Vec3(-y), Vec3(Vec3::Zero()), Vec3(-x)})
    add_square(soup, corner, x, y);
  add_square(soup, -y, y, z);
  add_square(soup, Vec3::Zero(), -x, z);
  const LocalModel model = model_over(soup, Vec3(1e-3, -6e-3, 1.5e-3));
  ASSERT_EQ(model.count, 2);
  EXPECT_FALSE(model.patches[0].joined);
  EXPECT_EQ(model.patches[0].normal, Vec3::UnitX());
  EXPECT_EQ(model.patches[1].normal, Vec3::UnitZ());
  EXPECT_NEAR(model.reach, std::hypot(1e-3, 6e-3), 1e-9);  // to the face behind the corner

  const LocalModel edge = model_over(soup, Vec3(1e-3, 1.1e-3, 2.5e-3));
  ASSERT_EQ(edge.count, 2);
  EXPECT_TRUE(edge.patches[0].joined);
  EXPECT_NEAR(edge.reach, 2.5e-3, 1e-9);  // to the plate
}

// Beyond the inspected triangles, the surface ends or something is above it.
TEST(MeshRings, EndWhereSomethingStandsAboveOrTheSurfaceDoes) {
  const TriangleSoup floor = test::sheet(0.15, 100);
  const Vec3 over(1e-3, 2e-3, 1e-3);
  EXPECT_GT(model_over(floor, over).reach, 0.06);
  // A ball of 4 mm is 30 mm above the floor.
  const LocalModel hung = model_over(
      test::joined(floor, test::moved(test::icosphere(4e-3, 2), Vec3(0, 0, 0.034))), over);
  ASSERT_EQ(hung.count, 1);
  EXPECT_LT(hung.reach, 0.03);
  // A ring is around the tool, 20 mm above the floor.
  const LocalModel ringed = model_over(
      test::joined(floor, test::moved(test::torus(0.045, 3e-3, 60, 12), Vec3(0, 0, 0.02))), over);
  ASSERT_EQ(ringed.count, 1);
  EXPECT_LT(ringed.reach, 0.042);
  // The floor is 5 mm lower after 30 mm.
  const LocalModel terrace = model_over(
      test::joined(test::sheet(0.03, 20), test::moved(test::sheet(0.15, 100), Vec3(0, 0, -5e-3))),
      over);
  ASSERT_EQ(terrace.count, 1);
  EXPECT_LE(terrace.reach, 0.03);
}

// For a ball, the distance to everything near is smaller by its radius.
TEST(MeshBall, MeetsWhatIsNotDescribedARadiusEarlier) {
  constexpr double kRadius = 3e-3;
  const TriangleSoup sheet = test::sheet(0.03, 3);
  const LocalModel above = model_over(sheet, Vec3(0.02, 0.0, 2e-3), {.radius = kRadius});
  ASSERT_EQ(above.count, 1);
  EXPECT_NEAR(above.reach, std::hypot(0.01, 2e-3) - kRadius, 1e-9);
  EXPECT_NEAR(above.patches[0].radius, std::hypot(0.01, kRadius) - kRadius, 1e-9);
  // From below nothing holds the tool. The model must omit the sheet above.
  const Scene scene("s", {test::mesh_object(sheet, {.radius = kRadius})});
  const LocalModel below = local_model(scene, Vec3(0.01, 0.0, -5e-3), scene.memory());
  EXPECT_EQ(below.count, 0);
  EXPECT_NEAR(below.reach, 5e-3 - kRadius, 1e-9);
}

Object grid_of(const Solid& solid, double resolution, Side side = Side::outside) {
  Object o;
  o.name = "grid";
  o.shape =
      Grid{std::make_shared<DistanceGrid<float>>(solid, GridOptions{.resolution = resolution})};
  o.felt_from = side;
  return o;
}

TEST(GridRings, EndWhereThePlateIsThinOrTheRoomLow) {
  // The plate is 4 mm thick. Below the middle the other face is nearer.
  const Vec3 over(1e-3, 2e-3, 2.5e-3);
  const LocalModel plate =
      model_at(grid_of(solid_of(Box{Vec3(0.06, 0.06, 2e-3)}), 5e-4), over, 2.0 * over);
  ASSERT_EQ(plate.count, 1);
  EXPECT_LT(plate.reach, 0.01);
  const LocalModel block = model_at(grid_of(solid_of(Box{Vec3(0.06, 0.06, 0.02)}), 1e-3),
                                    Vec3(1e-3, 2e-3, 0.0205), Vec3(1e-3, 2e-3, 0.03));
  EXPECT_GT(block.reach, 0.03);
  // The room is 20 mm high. Half way up, floor and ceiling are equally near.
  const Vec3 low(1e-3, 2e-3, -9.5e-3);
  const LocalModel room =
      model_at(grid_of(solid_of(Box{Vec3(0.06, 0.06, 0.01)}), 1e-3, Side::inside), low, 0.9 * low);
  ASSERT_EQ(room.count, 1);
  EXPECT_LT(room.reach, 0.02);
}

// A rod in any direction must get a cylinder along it.
TEST(GridRings, ARodIsACylinderWhicheverWayItPoints) {
  constexpr double kRadius = 0.02;
  Random random(2);
  for (int n = 0; n < 5; ++n) {
    const Vec3 along = random.direction();
    const Solid rod{Vec3::Constant(-0.05), Vec3::Constant(0.05),
                    [&](const Vec3& p) { return (p - along.dot(p) * along).norm() - kRadius; }};
    const Vec3 out = along.cross(random.direction()).normalized();
    const LocalModel model =
        model_at(grid_of(rod, 2e-3), (kRadius + 1e-3) * out, 1.5 * kRadius * out);
    ASSERT_EQ(model.count, 1);
    EXPECT_NEAR(model.patches[0].curvature, 1.0 / kRadius, 2.0);
    EXPECT_NEAR(std::abs(model.patches[0].axis.dot(along)), 1.0, 1e-3);
  }
}

}  // namespace
}  // namespace feltwire::fit_claims_test
