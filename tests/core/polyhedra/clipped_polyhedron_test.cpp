// A polyhedron that is cut by planes must stay closed, and must keep the volume below the planes.

#include "core/polyhedra/clipped_polyhedron.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "tests/core/polyhedra/solids.hpp"

namespace feltwire::clipped_polyhedron_test {
namespace {

using test::box_corners;
using test::placed;
using test::random_solid;

/// Calls visit(tag, corners) for each face. Its corners are counter-clockwise from outside.
template <class Visit>
void for_each_face(const ClippedPolyhedron& solid, const Visit& visit) {
  std::set<std::pair<std::size_t, std::size_t>>
      seen;  // corners, each with the edge that leads to it
  for (std::size_t begin = 0; begin < solid.corner_count(); ++begin)
    for (std::size_t entry = 0; entry < 3; ++entry) {
      std::vector<std::size_t> loop;
      ClippedPolyhedron::Neighbour at{begin, entry};
      while (seen.emplace(at.corner, at.slot).second) {
        EXPECT_EQ(solid.tags(at.corner)[at.slot], solid.tags(begin)[entry]);
        loop.push_back(at.corner);
        at = solid.neighbour(at.corner, (at.slot + 1) % 3);
      }
      if (!loop.empty()) visit(solid.tags(begin)[entry], std::span<const std::size_t>(loop));
    }
}

double volume(const ClippedPolyhedron& solid) {
  double six = 0.0;
  for_each_face(solid, [&](ClippedPolyhedron::Tag, std::span<const std::size_t> face) {
    for (std::size_t k = 2; k < face.size(); ++k)
      six += solid.corner(face[0]).dot(solid.corner(face[k - 1]).cross(solid.corner(face[k])));
  });
  return six / 6.0;
}

/// Checks that every directed edge of a face is the reverse of an edge of another face.
void expect_closed(const ClippedPolyhedron& solid) {
  std::map<std::pair<int, int>, int> edges;
  for_each_face(solid, [&](ClippedPolyhedron::Tag, std::span<const std::size_t> face) {
    for (std::size_t k = 0; k < face.size(); ++k) ++edges[{face[k], face[(k + 1) % face.size()]}];
  });
  for (const auto& [ends, count] : edges)
    EXPECT_EQ(count, (edges[{ends.second, ends.first}])) << ends.first << ' ' << ends.second;
}

TEST(ClippedPolyhedron, IsTheWholeSolidAtFirst) {
  test::Random random(3);
  for (int corners = 4; corners < 40; ++corners) {
    const Polyhedron solid = random_solid(random, 0.05, corners);
    const ClippedPolyhedron whole = placed(solid);
    expect_closed(whole);
    double six = 0.0;
    for (std::size_t f = 0; f < solid.planes.size(); ++f) {
      const auto loop = solid.face(f);
      for (std::size_t k = 2; k < loop.size(); ++k)
        six +=
            solid.vertices[loop[0]].dot(solid.vertices[loop[k - 1]].cross(solid.vertices[loop[k]]));
    }
    EXPECT_NEAR(volume(whole), six / 6.0, 1e-12 * six);
  }
}

// A narrow face is tilted against a wide face by slightly more than the joining tolerance.
TEST(ClippedPolyhedron, ANarrowFaceBesideAWideOneCloses) {
  std::vector<Vec3> corners;
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(1.0, 0.999),
                               std::pair(0.999, 1.0), std::pair(0.0, 1.0)})
      corners.emplace_back(x, y, z);
  corners[8].z() += 5e-10;
  const ClippedPolyhedron whole = placed(polyhedron(corners));
  expect_closed(whole);
  EXPECT_NEAR(volume(whole), 1.0 - 5e-7, 1e-9);
}

// A dome of many corners is flat within the joining tolerance, as in a fine mesh.
TEST(ClippedPolyhedron, ADomeThatIsNearlyFlatCloses) {
  for (const double bend : {1e-6, 1e-7, 1e-9, 1e-11, 1e-12}) {
    SCOPED_TRACE(bend);
    std::vector<Vec3> corners = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {1, 1, -1}};
    constexpr int kEach = 10;
    for (int i = 0; i <= kEach; ++i)
      for (int j = 0; j <= kEach; ++j) {
        const double x = 1.0 * i / kEach, y = 1.0 * j / kEach;
        corners.emplace_back(x, y, -bend * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5)));
      }
    ClippedPolyhedron dome = placed(polyhedron(corners));
    expect_closed(dome);
    EXPECT_NEAR(volume(dome), 1.0, bend);
    ASSERT_TRUE(dome.cut(Vec3(1.0, 0.1, 0.0), 0.53, 1));
    expect_closed(dome);
    EXPECT_NEAR(volume(dome), 0.48, bend);
  }
}

TEST(ClippedPolyhedron, ACutDividesTheVolume) {
  test::Random random(4);
  for (int i = 0; i < 50; ++i) {
    const ClippedPolyhedron whole = placed(random_solid(random, 0.05, 20));
    ClippedPolyhedron solid = whole;
    for (ClippedPolyhedron::Tag tag = 0; tag < 12 && !solid.empty(); ++tag) {
      const Vec3 normal = random.uniform(0.5, 2.0) * random.direction();
      const double offset = normal.norm() * random.uniform(-0.01, 0.03);
      ClippedPolyhedron above = solid;
      const double before = volume(solid);
      const bool below_left = solid.cut(normal, offset, tag);
      const bool above_left = above.cut(-normal, -offset, tag);
      expect_closed(solid);
      EXPECT_NEAR(volume(solid) + volume(above), before, 1e-12 * volume(whole));
      EXPECT_TRUE(below_left || above_left);
      for (std::size_t c = 0; c < solid.corner_count(); ++c)
        EXPECT_LT(normal.dot(solid.corner(c)) - offset, 1e-13);
    }
  }
}

TEST(ClippedPolyhedron, TheNewFaceHasTheTagAndTheOthersKeepTheirs) {
  ClippedPolyhedron solid = placed(polyhedron(box_corners(Vec3(1.0, 2.0, 3.0))));
  ASSERT_TRUE(solid.cut(Vec3(2.0, 0.0, 0.0), 1.0, 7));  // x <= 0.5
  EXPECT_NEAR(volume(solid), 1.5 * 4.0 * 6.0, 1e-12);
  std::set<ClippedPolyhedron::Tag> tags;
  for_each_face(solid, [&](ClippedPolyhedron::Tag tag, std::span<const std::size_t> face) {
    bool on_plane = true;
    for (const std::size_t c : face) on_plane &= std::abs(solid.corner(c).x() - 0.5) < 1e-12;
    EXPECT_EQ(tag == 7, on_plane);
    EXPECT_TRUE(on_plane || (tag >= ClippedPolyhedron::kOwn && tag < ClippedPolyhedron::kOwn + 6));
    EXPECT_TRUE(tags.insert(tag).second);
  });
  EXPECT_EQ(tags.size(), 6u);
}

// The planes pass through corners, along edges and on faces. Only rounding decides the side.
TEST(ClippedPolyhedron, StaysClosedOnPlanesThatTouch) {
  const Polyhedron cube = polyhedron(box_corners(Vec3::Constant(0.01)));
  ClippedPolyhedron solid = placed(cube);
  EXPECT_TRUE(solid.cut(Vec3::UnitX(), 0.01, 0));  // the plane of a face
  EXPECT_EQ(solid.corner_count(), 8u);
  EXPECT_TRUE(solid.cut(Vec3(1.0, 1.0, 0.0), 0.0, 1));  // a plane through two edges
  EXPECT_TRUE(solid.cut(Vec3(1.0, 1.0, 1.0), 0.01, 2));
  EXPECT_TRUE(solid.cut(Vec3(1.0, -1.0, 0.0), 0.0, 3));
  EXPECT_TRUE(solid.cut(Vec3(1.0, 0.0, 1.0), 0.0, 4));
  expect_closed(solid);
  EXPECT_GT(volume(solid), 0.0);
  EXPECT_FALSE(solid.cut(-Vec3::UnitX(), -0.01, 5));
  EXPECT_TRUE(solid.empty());
}

// A vertex in the middle of an edge has only two edges.
TEST(ClippedPolyhedron, TheGraphHasAVertexWithTwoEdges) {
  const std::vector<Vec3> vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1),
                                      Vec3(0.5, 0, 0)};
  Polyhedron solid;
  solid.vertices = vertices;
  solid.first = {0, 4, 8, 11, 14};
  solid.loop = {0, 2, 1, 4, 0, 4, 1, 3, 0, 3, 2, 1, 2, 3};
  solid.graph = corner_graph(vertices.size(), solid.first, solid.loop);
  ClippedPolyhedron whole = placed(solid);
  expect_closed(whole);
  EXPECT_NEAR(volume(whole), 1.0 / 6.0, 1e-12);
  ASSERT_TRUE(whole.cut(Vec3::UnitX(), 0.5, 0));
  EXPECT_NEAR(volume(whole), 1.0 / 6.0 - 1.0 / 48.0, 1e-12);
}

}  // namespace
}  // namespace feltwire::clipped_polyhedron_test
