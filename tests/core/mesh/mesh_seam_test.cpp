// Tests almost closed surfaces: seams, poles and corners that differ by rounding.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "core/contact/contact.hpp"
#include "core/mesh/mesh_file.hpp"
#include "tests/core/support.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::mesh_seam_test {
namespace {

constexpr double kRadius = 0.05;

using Number = std::function<double(double)>;
double as_double(double x) { return x; }
double as_float(double x) { return static_cast<double>(static_cast<float>(x)); }

/// Returns a ball of revolution, as programs make it. Such programs compute the last meridian again
/// at 2 pi, and the poles have the radius sin(pi). A text STL file has no common vertices.
std::string revolved_stl(int around, int along, const Number& rounded = as_double,
                         double turn = 2.0 * M_PI) {
  const auto at = [&](int i, int j) {
    const double angle = turn * i / around, polar = M_PI * j / along;
    const double r = kRadius * std::sin(polar);
    return Vec3(rounded(r * std::cos(angle)), rounded(r * std::sin(angle)),
                rounded(kRadius * std::cos(polar)));
  };
  std::string out = "solid revolved\n";
  const auto facet = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    out += "facet normal 0 0 0\nouter loop\n";
    for (const Vec3& v : {a, b, c}) {
      std::array<char, 128> line{};
      std::snprintf(line.data(), line.size(), "vertex %.17g %.17g %.17g\n", v.x(), v.y(), v.z());
      out += line.data();
    }
    out += "endloop\nendfacet\n";
  };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < along; ++j) {
      facet(at(i, j), at(i, j + 1), at(i + 1, j + 1));
      facet(at(i, j), at(i + 1, j + 1), at(i + 1, j));
    }
  return out + "endsolid\n";
}

/// Returns the number of straight approaches that pass through. Each approach leads from outside to
/// the centre, and the ball must push the tool back.
int let_through(const Object& object, const std::vector<Vec3>& targets) {
  int passed = 0;
  for (const Vec3& target : targets) {
    ContactMemory memory;
    Command felt;
    for (int n = 0; n <= 40; ++n)
      felt = touch(object, {(1.2 - 0.012 * n) * target, Vec3::Zero()}, memory);
    const double depth = kRadius - 0.72 * target.norm();
    passed +=
        felt.elastic.dot(target.normalized()) > 0.5 * object.material.stiffness * depth ? 0 : 1;
  }
  return passed;
}

/// Returns points on the ball's seam (longitude 0), slightly beside the seam, and at the poles.
std::vector<Vec3> on_the_seam(int count) {
  test::Random random(11);
  std::vector<Vec3> targets;
  for (int n = 0; n < count; ++n) {
    const double polar = random.uniform(0.02, M_PI - 0.02);
    const double beside = n % 4 == 0   ? 0.0
                          : n % 4 == 1 ? -0.5e-17
                          : n % 4 == 2 ? random.uniform(-2e-17, 0.0)
                                       : random.uniform(-1e-12, 1e-12);
    targets.emplace_back(kRadius * std::sin(polar), beside, kRadius * std::cos(polar));
  }
  return targets;
}

TEST(MeshSeam, AHandIsNotLetThroughTheSeamOfARevolvedBall) {
  for (const Number& rounded : {Number(as_double), Number(as_float)})
    for (const int around : {8, 37, 64}) {
      const TriangleSoup soup = parse_mesh(revolved_stl(around, 24, rounded), "ball.stl", 1.0);
      const Object ball = test::mesh_object(soup, {}, {.stiffness = 1000.0});
      EXPECT_EQ(let_through(ball, on_the_seam(10000)), 0) << around;
    }
}

TEST(MeshSeam, WhatTheSeamAndThePolesMissIsJoinedAndSaid) {
  for (const Number& rounded : {Number(as_double), Number(as_float)}) {
    const TriangleMesh mesh(parse_mesh(revolved_stl(64, 24, rounded), "ball.stl", 1.0));
    const MeshReport& report = mesh.report();
    EXPECT_TRUE(report.closed());
    EXPECT_EQ(report.holes.count, 0u);
    // The seam has 23 points. Each pole has points with a radius of sin(pi) or of the rounding
    // error.
    EXPECT_GE(report.joined, 23u);
    EXPECT_LT(report.joined_farthest, 1e-16);
    EXPECT_DOUBLE_EQ(report.weld, 1e-6 * report.size);
    EXPECT_NEAR(report.volume, 4.0 / 3.0 * M_PI * std::pow(kRadius, 3),
                2e-5 * report.volume + 5e-6);
    EXPECT_THAT(warnings(report, true),
                ::testing::Contains(::testing::HasSubstr("vertices of open edges were joined")));
    EXPECT_THAT(warnings(report, true),
                ::testing::Not(::testing::Contains(::testing::HasSubstr("hole"))));
  }
}

// The seam is not joined, and its cracks are as wide as the proxy's tolerance. The edges of the
// seam must hold the tool.
TEST(MeshSeam, CracksBelowTheSkinHoldWithoutBeingJoined) {
  for (const double turn : {2.0 * M_PI, 2.0 * M_PI - 1e-8, 2.0 * M_PI + 1e-8}) {
    const TriangleSoup soup = parse_mesh(revolved_stl(64, 24, as_double, turn), "ball.stl", 1.0);
    Object ball = test::mesh_object(soup, {}, {.stiffness = 1000.0});
    ball.shape = Mesh{std::make_shared<MeshSurface>(TriangleMesh(soup, 0.0), MeshOptions{})};
    EXPECT_FALSE(std::get<Mesh>(ball.shape).surface->mesh().report().closed());
    EXPECT_EQ(let_through(ball, on_the_seam(4000)), 0) << turn;
  }
}

TEST(MeshSeam, HolesAreMeasured) {
  // A slit of a tenth of a millimetre along a meridian. The slit becomes narrower towards the
  // poles.
  constexpr double kSlit = 1e-4;
  const TriangleMesh slit(
      parse_mesh(revolved_stl(64, 24, as_double, 2.0 * M_PI - kSlit / kRadius), "slit.stl", 1.0));
  EXPECT_EQ(slit.report().holes.count, 1u);
  EXPECT_NEAR(slit.report().holes.widest, 0.9 * kSlit, 0.1 * kSlit);
  // A box without its lid, and a box without one triangle.
  const Vec3 half(0.05, 0.04, 0.03);
  TriangleSoup box = test::box(half);
  box.triangles.resize(10);
  const MeshReport lid = TriangleMesh(box).report();
  EXPECT_EQ(lid.holes.count, 1u);
  EXPECT_NEAR(lid.holes.widest, 0.09, 0.0101);  // distance between the box's sides
  box = test::box(half);
  box.triangles.pop_back();
  EXPECT_EQ(TriangleMesh(box).report().holes.count, 1u);
  // The rings of a tube are separate.
  TriangleSoup tube;
  for (int i = 0; i < 64; ++i)
    for (const double z : {0.0, 0.1})
      tube.vertices.emplace_back(0.02 * std::cos(M_PI * i / 32), 0.02 * std::sin(M_PI * i / 32), z);
  for (std::uint32_t i = 0; i < 64; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % 64);
    tube.triangles.push_back({a, b, b + 1});
    tube.triangles.push_back({a, b + 1, a + 1});
  }
  const MeshReport ends = TriangleMesh(tube).report();
  EXPECT_EQ(ends.holes.count, 2u);
  EXPECT_NEAR(ends.holes.narrowest, 0.04, 2e-3);
  EXPECT_NEAR(ends.holes.widest, 0.04, 2e-3);
  EXPECT_THAT(warnings(ends, true),
              ::testing::ElementsAre(::testing::HasSubstr("the surface has holes, 2 holes 0.0")));
}

// A corner is in the middle of another side's edge. The two sides are no neighbours, but they have
// no gap.
TEST(MeshSeam, ACornerInTheMiddleOfAnEdgeLetsNothingThrough) {
  test::Random random(5);
  TriangleSoup soup;
  const auto triangle = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    for (const Vec3& v : {a, b, c}) {
      soup.triangles.resize((soup.vertices.size() / 3) + 1);
      soup.vertices.push_back(v);
    }
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.back() = {n - 3, n - 2, n - 1};
  };
  const Vec3 a(-0.05, -0.03, 0.0), b(0.05, 0.031, 0.0), left(-0.06, 0.07, 0.0),
      right(0.06, -0.07, 0.0);
  std::vector<Vec3> corners = {a};
  for (const double part : {0.13, 0.37, 0.61, 0.89}) corners.push_back(a + part * (b - a));
  corners.push_back(b);
  triangle(a, b, left);
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) triangle(corners[i + 1], corners[i], right);
  const Object plate = test::mesh_object(soup, {}, {.stiffness = 1000.0});
  for (int n = 0; n < 20000; ++n) {
    const Vec3 target = a + random.uniform(0.01, 0.99) * (b - a);
    ContactMemory memory;
    touch(plate, {target + Vec3(0, 0, 0.01), Vec3::Zero()}, memory);
    const Command felt = touch(plate, {target - Vec3(0, 0, 0.004), Vec3::Zero()}, memory);
    ASSERT_NEAR(felt.elastic.z(), 4.0, 1e-3) << n;
  }
}

TEST(MeshSeam, AVertexFarAwayLosesNoDetailAndIsNamed) {
  // The ball of revolution has a spike that extends to 1e6 m.
  TriangleSoup soup = parse_mesh(revolved_stl(37, 24), "ball.stl", 1.0);
  const auto n = static_cast<std::uint32_t>(soup.vertices.size());
  const std::size_t count = TriangleMesh(soup).triangles().size();
  soup.vertices.insert(soup.vertices.end(), {{0, 0, 0.2}, {0.001, 0, 0.2}, {0, 1e6, 0.2}});
  soup.triangles.push_back({n, n + 1, n + 2});
  const TriangleMesh mesh(soup);
  EXPECT_EQ(mesh.triangles().size(), count + 1);
  EXPECT_EQ(mesh.report().boundary_edges, 3u);  // the edges of the spike itself
  EXPECT_LT(mesh.report().joined_farthest, 1e-9);
  EXPECT_THAT(warnings(mesh.report(), true),
              ::testing::Contains(::testing::HasSubstr("a vertex lies far away from the others")));
}

// The report must give the height of a triangle that the surface omits.
TEST(MeshSeam, ATriangleThatIsLeftOutIsMeasured) {
  TriangleSoup soup = test::sheet(0.1);
  const auto n = static_cast<std::uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), {{0, 0, 0.2}, {1e-10, 0, 0.2}, {0, 9e5, 0.2}});
  soup.triangles.push_back({n, n + 1, n + 2});
  const MeshReport thin = TriangleMesh(soup, 0.0).report();
  EXPECT_EQ(thin.degenerate, 1u);
  EXPECT_NEAR(thin.degenerate_height, 1e-10, 1e-12);
  EXPECT_THAT(warnings(thin, false),
              ::testing::Contains(::testing::HasSubstr("the highest is 1e-10 m high")));
}

}  // namespace
}  // namespace feltwire::mesh_seam_test
