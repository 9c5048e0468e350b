// Tests T-junctions: corners of one part of a surface in the middle of edges of another part.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/contact/contact.hpp"
#include "core/mesh/mesh_distance.hpp"
#include "core/mesh/mesh_file.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::edge_splits_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// Returns a box with faces that are divided into squares. Each face may have a different number of
/// squares.
TriangleSoup cut_box(const Vec3& half, const std::array<int, 6>& cuts) {
  TriangleSoup soup;
  for (std::size_t face = 0; face < cuts.size(); ++face) {
    const TriangleSoup all = test::box(half, cuts[face]);
    const std::size_t own = all.triangles.size() / cuts.size();
    TriangleSoup one{all.vertices, {}};
    one.triangles.assign(all.triangles.begin() + static_cast<std::ptrdiff_t>(face * own),
                         all.triangles.begin() + static_cast<std::ptrdiff_t>((face + 1) * own));
    soup = test::joined(std::move(soup), one);
  }
  return soup;
}

TEST(EdgeSplits, ATopThatIsCutInTwoIsNoHole) {
  const TriangleMesh mesh(
      parse_mesh("v 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nv 0 0 20\nv 20 0 20\nv 20 20 20\n"
                 "v 0 20 20\nv 10 0 20\nv 10 20 20\nf 1 4 3 2\nf 5 9 10 8\nf 9 6 7 10\n"
                 "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
                 "slit.obj", 1e-3));
  EXPECT_TRUE(mesh.report().closed());
  EXPECT_EQ(mesh.report().holes.count, 0u);
  EXPECT_EQ(mesh.report().split.count, 2u);
  EXPECT_EQ(mesh.report().split.added, 2u);
  EXPECT_NEAR(mesh.report().volume, 8e-6, 1e-20);
  EXPECT_THAT(warnings(mesh.report(), true), Contains(HasSubstr("were split there")));
  EXPECT_NO_THROW(solid_of(mesh));
}

/// Each edge of the box has corners of both faces. The two faces share none of these corners.
TEST(EdgeSplits, AnyNumberOfCornersOnAnyNumberOfEdges) {
  const Vec3 half(0.05, 0.04, 0.03);
  std::mt19937 random(3);
  for (const std::array<int, 6>& cuts :
       {std::array{1, 2, 3, 4, 5, 7}, std::array{1, 1, 1, 1, 1, 9}, std::array{2, 3, 2, 3, 5, 4},
        std::array{16, 1, 11, 13, 7, 3}}) {
    TriangleSoup soup = cut_box(half, cuts);
    // The box has any pose, single precision as in an STL file, and a random order of triangles.
    const Quaternion turn(0.3, 0.5, -0.2, 0.7);
    for (const bool rounded : {false, true}) {
      TriangleSoup placed = soup;
      for (Vec3& v : placed.vertices) {
        v = turn.normalized() * v + Vec3(0.2, -0.1, 0.3);
        if (rounded) v = v.cast<float>().cast<double>();
      }
      std::ranges::shuffle(placed.triangles, random);
      const TriangleMesh mesh(placed);
      EXPECT_TRUE(mesh.report().closed()) << holes_text(mesh.report());
      EXPECT_NEAR(mesh.report().volume, 8 * half.prod(), (rounded ? 1e-5 : 1e-12) * half.prod());
      EXPECT_LE(mesh.report().split.farthest, 1e-6 * mesh.report().size);
      // A client makes a mesh of the result's triangles. Both meshes must be equal.
      const TriangleMesh again({mesh.vertices(), mesh.triangles()}, 0.0);
      EXPECT_EQ(again.triangles(), mesh.triangles());
    }
  }
}

/// Files of some programs cover a T-junction by a triangle without area.
TEST(EdgeSplits, WhatADegenerateTriangleHeldTogetherStaysTogether) {
  TriangleSoup soup = test::box(Vec3(0.01, 0.01, 0.01));
  // The test splits an edge in the middle, adds a degenerate triangle, and divides the neighbour
  // triangle.
  const Triangle cut = soup.triangles[0];
  const Vec3 a = soup.vertices[cut[0]], b = soup.vertices[cut[1]];
  const auto m = static_cast<std::uint32_t>(soup.vertices.size());
  soup.vertices.emplace_back(0.5 * (a + b));
  soup.triangles[0] = {cut[0], m, cut[2]};
  soup.triangles.push_back({m, cut[1], cut[2]});
  soup.triangles.push_back({cut[0], cut[1], m});
  const TriangleMesh mesh(soup);
  EXPECT_EQ(mesh.report().degenerate, 1u);
  EXPECT_TRUE(mesh.report().closed());
  EXPECT_NEAR(mesh.report().volume, 8e-6, 1e-18);
}

TEST(EdgeSplits, AHandFeelsTheSameOnTheSeam) {
  const Vec3 half(0.05, 0.04, 0.03);
  const Object whole = test::mesh_object(test::box(half), {}, {.stiffness = 1000.0});
  const Object cut =
      test::mesh_object(cut_box(half, {3, 5, 2, 7, 4, 1}), {}, {.stiffness = 1000.0});
  std::mt19937 random(8);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  for (int n = 0; n < 2000; ++n) {
    // Points near an edge between two faces.
    const Vec3 at(0.05 + 0.003 * draw(random), 0.04 + 0.003 * draw(random), 0.029 * draw(random));
    ContactMemory one, other;
    touch(whole, {1.2 * at, Vec3::Zero()}, one);
    touch(cut, {1.2 * at, Vec3::Zero()}, other);
    const Command felt = touch(cut, {at, Vec3::Zero()}, other);
    EXPECT_LT((touch(whole, {at, Vec3::Zero()}, one).elastic - felt.elastic).norm(), 1e-6) << n;
  }
}

TEST(EdgeSplits, HolesStayHoles) {
  TriangleSoup box = cut_box(Vec3(0.05, 0.04, 0.03), {3, 5, 2, 7, 4, 2});
  box.triangles.pop_back();
  const MeshReport open = TriangleMesh(box).report();
  EXPECT_EQ(open.holes.count, 1u);
  EXPECT_GE(open.boundary_edges, 3u);
  EXPECT_THROW(solid_of(TriangleMesh(box)), std::invalid_argument);
  // The position of a lid is wrong by a tenth of a millimetre.
  TriangleSoup lid = cut_box(Vec3(0.05, 0.04, 0.03), {1, 1, 1, 1, 1, 1});
  for (const std::uint32_t i : lid.triangles.back()) lid.vertices[i].z() += 1e-4;
  EXPECT_GT(TriangleMesh(lid).report().boundary_edges, 0u);
  // A sheet must stay open and must not be split.
  const MeshReport sheet = TriangleMesh(test::sheet(0.1, 5)).report();
  EXPECT_EQ(sheet.boundary_edges, 20u);
  EXPECT_EQ(sheet.split.count, 0u);
  // Two sheets meet only in the middle of their rims. They must share no edge.
  TriangleSoup tee = test::sheet(0.1);
  tee.vertices.insert(tee.vertices.end(), {{0.1, 0.0, 0.0}, {0.3, 0.1, 0.0}, {0.3, -0.1, 0.0}});
  tee.triangles.push_back({4, 6, 5});
  EXPECT_EQ(TriangleMesh(tee).report().split.count, 0u);
}

/// Coordinates with few decimals move a corner away from its edge. The message must name a weld
/// distance that joins both.
TEST(EdgeSplits, RoundedCornersAreClosedByTheWeldThatIsNamed) {
  const Eigen::AngleAxisd turn(0.6, Vec3(1, 2, 3).normalized());
  int named = 0;
  for (const double unit : {1e-6, 1e-7, 1e-8}) {
    TriangleSoup box = cut_box(Vec3(0.05, 0.04, 0.03), {3, 5, 2, 7, 4, 2});
    for (Vec3& v : box.vertices) v = unit * (turn * v / unit).array().round().matrix();
    const MeshReport report = TriangleMesh(box).report();
    if (report.closed()) continue;
    ++named;
    const std::string text = mend_text(report), begin = "set \"weld\": ";
    ASSERT_THAT(text, HasSubstr(begin)) << unit;
    const double weld = std::stod(text.substr(begin.size()));
    EXPECT_LT(weld, 10.0 * unit);
    EXPECT_TRUE(TriangleMesh(box, weld).report().closed()) << unit;
  }
  EXPECT_GE(named, 1);
  TriangleSoup open = test::box(Vec3(0.05, 0.04, 0.03), 2);
  open.triangles.pop_back();
  EXPECT_EQ(mend_text(TriangleMesh(open).report()), "mend it");
}

/// Two doubled sheets meet at a T. Both sides of each face must be split equally.
TEST(EdgeSplits, FacesWithBothSidesAreSplitToo) {
  TriangleSoup soup;
  soup.vertices = {{0, 0, 0}, {0.02, 0, 0}, {0.01, 0.02, 0}, {0.01, 0, 0}, {0.01, -0.02, 0}};
  for (const Triangle& t : {Triangle{0, 1, 2}, Triangle{0, 4, 3}, Triangle{3, 4, 1}}) {
    soup.triangles.push_back(t);
    soup.triangles.push_back({t[0], t[2], t[1]});
  }
  const TriangleMesh mesh(soup);
  EXPECT_EQ(mesh.report().both_sides, 4u);
  EXPECT_EQ(mesh.triangles().size(), 8u);
  EXPECT_EQ(mesh.report().boundary_edges, 4u);
}

/// A weld distance of a millimetre must not collapse smaller features.
TEST(EdgeSplits, ALargeWeldFoldsNothing) {
  for (const double weld : {1e-4, 1e-3, 1e-2}) {
    const TriangleSoup box = cut_box(Vec3(0.005, 0.004, 0.003), {3, 5, 2, 7, 4, 2});
    const TriangleMesh mesh(box, weld);
    EXPECT_TRUE(mesh.report().closed());
    EXPECT_NEAR(mesh.report().volume, 8 * 60e-9, 1e-15);
  }
}

}  // namespace
}  // namespace feltwire::edge_splits_test
