#include "core/mesh/triangle_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/meshes.hpp"

namespace feltwire::triangle_mesh_test {
namespace {

TEST(TriangleMesh, ASphereIsClosedAndHoldsItsVolume) {
  const TriangleMesh mesh(test::icosphere(0.09, 4));
  EXPECT_TRUE(mesh.report().closed());
  EXPECT_EQ(mesh.triangles().size(), 5120u);
  const double ball = 4.0 / 3.0 * M_PI * std::pow(0.09, 3);
  EXPECT_NEAR(mesh.report().volume, ball, 0.005 * ball);
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = mesh.neighbour(t, k);
      ASSERT_NE(other, TriangleMesh::kNone);
      bool back = false;
      for (int j = 0; j < 3; ++j) back |= mesh.neighbour(other, j) == t;
      EXPECT_TRUE(back);
    }
}

TEST(TriangleMesh, CornersThatStandOnEachOtherBecomeOne) {
  const TriangleMesh mesh(test::box(Vec3(0.05, 0.04, 0.03), 3));
  EXPECT_TRUE(mesh.report().closed());
  EXPECT_EQ(mesh.triangles().size(), 6u * 9 * 2);
  EXPECT_EQ(mesh.vertices().size(), mesh.triangles().size() / 2 + 2);  // Euler's formula
  EXPECT_NEAR(mesh.report().volume, 8 * 0.05 * 0.04 * 0.03, 1e-16);
}

TEST(TriangleMesh, OriginIsTheMiddleWhereverTheSurfaceLies) {
  const TriangleMesh mesh(test::moved(test::box(Vec3(0.5, 0.25, 0.125)), Vec3(1e6, -1e6, 3.0)));
  EXPECT_EQ(mesh.origin(), Vec3(1e6, -1e6, 3.0));
  EXPECT_EQ(mesh.half_extents(), Vec3(0.5, 0.25, 0.125));
  for (const Vec3& v : mesh.vertices()) EXPECT_EQ(v.cwiseAbs(), Vec3(0.5, 0.25, 0.125));
}

TEST(TriangleMesh, NoSizeIsDegenerateAndNoSliverIsKept) {
  // A surface has a triangle of a tenth of a nanometre and a triangle of a megametre.
  TriangleSoup soup;
  soup.vertices = {{0, 0, 0},   {1e-10, 0, 0}, {0, 1e-10, 0}, {1e6, 0, 0},
                   {0, 1e6, 0}, {1, 0, 0},     {2, 0, 0},     {3, 1e-18, 0}};
  soup.triangles = {{0, 1, 2}, {0, 3, 4}, {0, 5, 6}, {5, 6, 7}, {1, 1, 2}};
  const TriangleMesh mesh(soup);
  EXPECT_EQ(mesh.triangles().size(), 2u);
  EXPECT_EQ(mesh.report().degenerate, 3u);
  for (std::uint32_t t = 0; t < 2; ++t)
    EXPECT_NEAR((triangle_normal(mesh.corners(t)) - Vec3::UnitZ()).norm(), 0.0, 1e-5);
  TriangleSoup none = soup;
  none.triangles = {{0, 5, 6}};
  EXPECT_THROW(TriangleMesh{none}, std::invalid_argument);
}

TEST(TriangleMesh, DuplicatesAreLeftOutOnceWhicheverWayRound) {
  TriangleSoup soup = test::icosphere(1.0, 1);
  const auto [a, b, c] = soup.triangles[7];
  soup.triangles.push_back({b, c, a});
  soup.triangles.push_back({c, b, a});
  const TriangleMesh mesh(soup);
  EXPECT_EQ(mesh.report().duplicate, 2u);
  EXPECT_TRUE(mesh.report().closed());
}

TEST(TriangleMesh, OpenTurnedAndCrowdedEdgesAreCounted) {
  const TriangleMesh sheet(test::sheet(1.0, 4));
  EXPECT_EQ(sheet.report().boundary_edges, 16u);
  EXPECT_FALSE(sheet.report().closed());

  TriangleSoup turned = test::icosphere(1.0, 1);
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  EXPECT_EQ(TriangleMesh(turned).report().turned_edges, 3u);

  TriangleSoup fin = test::sheet(1.0);
  fin.vertices.emplace_back(0.0, 0.0, 1.0);
  fin.triangles.push_back({0, 3, 4});  // This triangle stands on the diagonal.
  EXPECT_EQ(TriangleMesh(fin).report().non_manifold_edges, 1u);
}

TEST(TriangleMesh, TurnedInsideOutItsVolumeIsNegativeAndNeighboursStay) {
  TriangleMesh mesh(test::icosphere(1.0, 2));
  const double volume = mesh.report().volume;
  mesh.turn();
  EXPECT_EQ(mesh.report().volume, -volume);
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    EXPECT_LT(triangle_normal(mesh.corners(t)).dot(mesh.corners(t)[0]), 0.0);
    for (int k = 0; k < 3; ++k) {
      const Triangle& beyond = mesh.triangles()[mesh.neighbour(t, k)];
      for (const int corner : {k, (k + 1) % 3})
        EXPECT_THAT(beyond,
                    ::testing::Contains(mesh.triangles()[t][static_cast<std::size_t>(corner)]));
    }
  }
}

TEST(TriangleMesh, WhatIsNoSurfaceIsRefused) {
  TriangleSoup soup = test::icosphere(1.0, 0);
  soup.triangles.push_back({0, 1, 12});
  EXPECT_THROW(TriangleMesh{soup}, std::invalid_argument);
  soup = test::icosphere(1.0, 0);
  soup.vertices[3].y() = std::nan("");
  EXPECT_THROW(TriangleMesh{soup}, std::invalid_argument);
  soup.vertices[3].y() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(TriangleMesh{soup}, std::invalid_argument);
  EXPECT_THROW(TriangleMesh{TriangleSoup{}}, std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::triangle_mesh_test
