// Compares signed distances to closed meshes with closed forms, and with a search of all triangles.

#include "core/mesh/mesh_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/grid/signed_distance.hpp"
#include "core/mesh/tessellation.hpp"
#include "tests/core/support.hpp"

namespace feltwire::mesh_distance_test {
namespace {

std::string error_of(const TriangleSoup& soup) {
  try {
    solid_of(TriangleMesh(soup));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "let through";
}

TEST(MeshDistance, ABoxOfTrianglesIsTheBox) {
  const Box box{Vec3(0.03, 0.02, 0.01)};
  const Solid solid = solid_of(TriangleMesh(tessellate(box, 3)));
  EXPECT_EQ(solid.high, box.half_extents);
  test::Random random(1);
  for (int i = 0; i < 5000; ++i) {
    Vec3 p;
    for (double& x : p) x = random.uniform(-0.04, 0.04);
    EXPECT_NEAR(solid.distance(p), signed_distance(box, Side::outside, p).distance, 1e-15);
  }
  // The points are on edges and corners, and straight outwards from there.
  for (const double x : {-0.03, 0.03})
    for (const double y : {-0.02, 0.02})
      for (const double out : {0.5, 0.99, 1.01, 2.0}) {
        const Vec3 p(x * out, y * out, 0.01 * out);
        EXPECT_NEAR(solid.distance(p), signed_distance(box, Side::outside, p).distance, 1e-15);
      }
}

TEST(MeshDistance, EveryShapeOfTrianglesIsNearlyTheShape) {
  const std::vector<Shape> shapes = {Sphere{0.02}, Capsule{0.01, 0.02}, Capsule{0.01, 0.0},
                                     Cylinder{0.015, 0.01}};
  for (const Shape& shape : shapes) {
    const Solid solid = solid_of(TriangleMesh(tessellate(shape, 100)));
    test::Random random(2);
    for (int i = 0; i < 500; ++i) {
      Vec3 p;
      for (double& x : p) x = random.uniform(-0.04, 0.04);
      EXPECT_NEAR(solid.distance(p), signed_distance(shape, Side::outside, p).distance, 4e-5)
          << shape.index() << ": " << p.transpose();
    }
  }
}

/// Returns a ball with deep folds and without symmetry.
TriangleSoup crumpled(int level) {
  TriangleSoup soup = icosphere(1.0, level);
  test::Random random(3);
  for (Vec3& v : soup.vertices) v *= random.uniform(0.5, 1.0);
  return soup;
}

TEST(MeshDistance, IsTheNearestOfAllTriangles) {
  const TriangleSoup soup = crumpled(2);
  const Solid solid = solid_of(TriangleMesh(soup));
  test::Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = random.uniform(0.0, 2.0) * random.direction();
    // An independent reference: descent on a convex function finds the nearest point of a triangle.
    double nearest = 1e9;
    for (const Triangle& t : soup.triangles) {
      const Vec3 a = soup.vertices[t[0]], b = soup.vertices[t[1]] - a, c = soup.vertices[t[2]] - a;
      const auto on_edge = [&](const Vec3& from, const Vec3& way) {
        const double s = std::clamp((p - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (p - from - s * way).norm());
      };
      on_edge(a, b);
      on_edge(a, c);
      on_edge(a + b, c - b);
      Eigen::Matrix<double, 3, 2> sides;
      sides << b, c;
      const Eigen::Vector2d uv =
          (sides.transpose() * sides).inverse() * sides.transpose() * (p - a);
      if (uv.minCoeff() >= 0.0 && uv.sum() <= 1.0)
        nearest = std::min(nearest, (p - a - sides * uv).norm());
    }
    EXPECT_NEAR(std::abs(solid.distance(p)), nearest, 1e-12);
  }
}

// The solid angle of the complete surface is the reference for the sign: 4 pi inside, 0 outside.
TEST(MeshDistance, TheSignIsThatOfTheSolidAngle) {
  const TriangleSoup soup = crumpled(2);
  const Solid solid = solid_of(TriangleMesh(soup));
  test::Random random(5);
  int inside = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = random.uniform(0.3, 1.1) * random.direction();
    double angle = 0.0;
    for (const Triangle& t : soup.triangles) {  // van Oosterom & Strackee 1983
      const Vec3 a = soup.vertices[t[0]] - p, b = soup.vertices[t[1]] - p,
                 c = soup.vertices[t[2]] - p;
      angle +=
          2.0 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                  b.dot(c) * a.norm() + c.dot(a) * b.norm());
    }
    EXPECT_EQ(solid.distance(p) < 0.0, angle > 2.0 * M_PI) << p.transpose();
    inside += solid.distance(p) < 0.0 ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
  EXPECT_LT(inside, 900);
}

TEST(MeshDistance, NeitherPlaceNorSizeMatters) {
  const Box box{Vec3(0.03, 0.02, 0.01)};
  for (const double scale : {1e-5, 1.0, 1e5})
    for (const double away : {0.0, 1e6}) {
      TriangleSoup soup = tessellate(Box{scale * box.half_extents}, 3);
      for (Vec3& v : soup.vertices) v.x() += away * scale;
      const Solid solid = solid_of(TriangleMesh(soup));
      test::Random random(6);
      for (int i = 0; i < 500; ++i) {
        Vec3 p;
        for (double& x : p) x = random.uniform(-0.04, 0.04);
        const double exact = scale * signed_distance(box, Side::outside, p).distance;
        const double digits = away > 0.0 ? 1e-9 : 1e-15;  // At 1e6 a double has no more digits.
        EXPECT_NEAR(solid.distance(scale * (p + Vec3(away, 0, 0))), exact, digits * scale);
      }
    }
}

TEST(MeshDistance, RefusesWhatIsNoSolid) {
  const TriangleSoup box = tessellate(Box{Vec3(1, 1, 1)}, 3);
  EXPECT_EQ(error_of(box), "let through");
  TriangleSoup open = box;
  open.triangles.pop_back();
  EXPECT_EQ(error_of(open), "mesh: is open at 3 edges, so that nothing is inside; close the holes");
  TriangleSoup inside_out = box;
  for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(error_of(inside_out).rfind("mesh: is inside out", 0), 0u);
  TriangleSoup turned = box;
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_EQ(error_of(turned).rfind("mesh: has triangles that disagree", 0), 0u);
  TriangleSoup finned = box;
  finned.vertices.emplace_back(3, 3, 3);
  finned.triangles.push_back({1, 3, 8});
  EXPECT_NE(error_of(finned), "let through");
}

TEST(MeshDistance, OfASurfaceIsThatOfItsMesh) {
  const auto surface = std::make_shared<const MeshSurface>(TriangleMesh(crumpled(2)));
  const Solid solid = solid_of(surface), own = solid_of(TriangleMesh(crumpled(2)));
  EXPECT_EQ(surface.use_count(), 2);  // The solid uses the mesh's tree without a copy.
  test::Random random(8);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = random.uniform(0.0, 2.0) * random.direction();
    EXPECT_EQ(solid.distance(p), own.distance(p));
  }
}

TEST(MeshDistance, AGridOfAMeshIsTheMesh) {
  const Solid solid = solid_of(TriangleMesh(icosphere(0.03, 3)));
  const DistanceGrid<float> grid(solid, {.resolution = 1e-3});
  test::Random random(7);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = (0.03 + random.uniform(-2e-3, 2e-3)) * random.direction();
    EXPECT_NEAR(grid.at(p).distance, solid.distance(p), 5e-5);  // [m] The grid rounds the edges.
  }
}

}  // namespace
}  // namespace feltwire::mesh_distance_test
