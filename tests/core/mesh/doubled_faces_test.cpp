// Tests triangles on equal corners that face both sides.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/contact/contact.hpp"
#include "core/mesh/mesh_file.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::doubled_faces_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kStiffness = 1000.0;  // [N/m]

Triangle turned(const Triangle& t) { return {t[0], t[2], t[1]}; }

/// Returns the force [N] along z on a point that comes from above `place` and ends `depth` [m]
/// below.
double felt_from_above(const Object& object, const Vec3& place, double depth) {
  ContactMemory memory;
  touch(object, {place + Vec3(0, 0, 0.002), Vec3::Zero()}, memory);
  return touch(object, {place - Vec3(0, 0, depth), Vec3::Zero()}, memory).elastic.z();
}
double felt_from_below(const Object& object, const Vec3& place, double depth) {
  ContactMemory memory;
  touch(object, {place - Vec3(0, 0, 0.002), Vec3::Zero()}, memory);
  return -touch(object, {place + Vec3(0, 0, depth), Vec3::Zero()}, memory).elastic.z();
}

/// Returns a 20 mm cube with two copies of the first half of its top, in either order. `mirrored`
/// reverses the x axis.
std::string cube(bool turned_first, bool mirrored = false) {
  std::string text;
  for (const char* corner :
       {"0 0 0", "20 0 0", "20 20 0", "0 20 0", "0 0 20", "20 0 20", "20 20 20", "0 20 20"})
    text += std::string("v ") + (mirrored ? "-" : "") + corner + "\n";
  text += turned_first ? "f 5 7 6\nf 5 6 7\n" : "f 5 6 7\nf 5 7 6\n";
  return text +
         "f 5 7 8\nf 1 3 2\nf 1 4 3\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 "
         "5\nf 4 5 8\n";
}

TEST(DoubledFaces, TheOneThatAgreesWithItsNeighboursIsKeptInEitherOrder) {
  for (const bool mirrored : {false, true})
    for (const bool turned_first : {false, true}) {
      TriangleMesh mesh(parse_mesh(cube(turned_first, mirrored), "cube.obj", 1e-3));
      EXPECT_TRUE(mesh.report().closed());
      EXPECT_NEAR(std::abs(mesh.report().volume), 8e-6, 1e-18);
      EXPECT_EQ(mesh.report().opposed, 1u);
      EXPECT_EQ(mesh.report().both_sides, 0u);
      EXPECT_THAT(warnings(mesh.report(), true),
                  Contains(HasSubstr("agrees with its neighbours was kept")));
      if (mirrored) {
        EXPECT_LT(mesh.report().volume, 0.0);
        mesh.turn();
      }
      Object object;
      object.shape = Mesh{std::make_shared<MeshSurface>(std::move(mesh))};
      object.material.stiffness = kStiffness;
      const double x = mirrored ? -0.015 : 0.015;
      EXPECT_NEAR(felt_from_above(object, {x, 0.005, 0.02}, 0.002), 2.0, 1e-9) << turned_first;
    }
}

/// Adds copies to a random `share` of a ball's faces. Some copies are turned over.
TriangleSoup with_company(const TriangleSoup& ball, std::mt19937& random, double share) {
  TriangleSoup soup{ball.vertices, {}};
  std::uniform_real_distribution<double> draw(0.0, 1.0);
  for (const Triangle& t : ball.triangles) {
    soup.triangles.push_back(t);
    if (draw(random) > share) continue;
    for (int copies = 0; copies < 3; ++copies)
      if (copies == 0 || draw(random) < 0.4)
        soup.triangles.push_back(copies == 0 || draw(random) < 0.5 ? turned(t) : t);
  }
  std::ranges::shuffle(soup.triangles, random);
  for (Triangle& t : soup.triangles)
    std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random() % 3), t.end());
  return soup;
}

TEST(DoubledFaces, PatchesOfThemAreDecidedByTheFacesRoundThem) {
  std::mt19937 random(4);
  const TriangleSoup ball = test::icosphere(0.05, 3);
  const double volume = TriangleMesh(ball).report().volume;
  for (const double share : {0.01, 0.3, 0.7, 0.97})
    for (int n = 0; n < 5; ++n) {
      const TriangleMesh mesh(with_company(ball, random, share));
      EXPECT_TRUE(mesh.report().closed()) << share;
      EXPECT_EQ(mesh.triangles().size(), ball.triangles.size());
      EXPECT_NEAR(mesh.report().volume, volume, 1e-15);
      EXPECT_EQ(mesh.report().both_sides, 0u);
    }
}

/// Corners that an STL file or rounding separates must be joined first.
TEST(DoubledFaces, CornersThatAreWeldedCountToo) {
  std::mt19937 random(5);
  const TriangleSoup company = with_company(test::icosphere(0.05, 2), random, 0.5);
  TriangleSoup loose;
  for (const Triangle& t : company.triangles) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (const std::uint32_t i : t) loose.vertices.push_back(company.vertices[i]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  const TriangleMesh mesh(loose);
  EXPECT_TRUE(mesh.report().closed());
  EXPECT_EQ(mesh.triangles().size(), 320u);
}

TEST(DoubledFaces, AWholeDoubledShellIsFeltFromBothSidesInAnyOrder) {
  const TriangleSoup ball = test::icosphere(0.05, 2);
  for (const bool turned_first : {false, true}) {
    TriangleSoup soup{ball.vertices, {}};
    for (const Triangle& t : ball.triangles) {
      soup.triangles.push_back(turned_first ? turned(t) : t);
      soup.triangles.push_back(turned_first ? t : turned(t));
    }
    const Object shell = test::mesh_object(soup, {}, {.stiffness = kStiffness});
    const MeshReport& report = std::get<Mesh>(shell.shape).surface->mesh().report();
    EXPECT_EQ(report.both_sides, ball.triangles.size());
    EXPECT_FALSE(report.closed());
    EXPECT_THAT(warnings(report, true), Contains(HasSubstr("felt from both sides")));
    std::mt19937 random(6);
    std::uniform_real_distribution<double> draw(-0.02, 0.02);
    for (int n = 0; n < 200; ++n) {
      const double x = draw(random), y = draw(random);
      // The faces of a ball with 2 subdivisions are up to 1.5 mm inside the sphere.
      const Vec3 top(x, y, std::sqrt(0.0025 - x * x - y * y));
      ContactMemory memory;
      touch(shell, {1.05 * top, Vec3::Zero()}, memory);
      EXPECT_GT(touch(shell, {0.9 * top, Vec3::Zero()}, memory).elastic.dot(top), 0.0);
      memory = {};
      touch(shell, {0.9 * top, Vec3::Zero()}, memory);
      EXPECT_LT(touch(shell, {1.05 * top, Vec3::Zero()}, memory).elastic.dot(top), 0.0);
    }
    // If the mesh must bound a solid, its faces must point outwards.
    const TriangleMesh solid(soup, {}, true);
    EXPECT_TRUE(solid.report().closed());
    EXPECT_NEAR(solid.report().volume, TriangleMesh(ball).report().volume, 1e-15);
  }
}

TEST(DoubledFaces, ASheetIsFeltFromBothSidesByAPointAndByABall) {
  const TriangleSoup sheet = test::sheet(0.05, 3);
  for (const bool turned_first : {false, true})
    for (const double radius : {0.0, 0.002}) {
      TriangleSoup soup{sheet.vertices, {}};
      for (const Triangle& t : sheet.triangles) {
        soup.triangles.push_back(turned_first ? turned(t) : t);
        soup.triangles.push_back(turned_first ? t : turned(t));
        if (soup.triangles.size() % 3 == 0)
          soup.triangles.push_back(t);  // A third copy must have no effect.
      }
      const Object both = test::mesh_object(soup, {.radius = radius}, {.stiffness = kStiffness});
      const MeshReport& report = std::get<Mesh>(both.shape).surface->mesh().report();
      EXPECT_EQ(report.both_sides, sheet.triangles.size());
      EXPECT_FALSE(report.closed());
      EXPECT_EQ(report.boundary_edges, 12u);
      EXPECT_EQ(report.holes.count, 1u);
      for (const Vec3& place : {Vec3(0.01, 0.013, 0), Vec3(0, 0, 0), Vec3(-0.0166, 0.01, 0)}) {
        EXPECT_NEAR(felt_from_above(both, place, 0.001), 1.0 + radius * kStiffness, 0.01);
        EXPECT_NEAR(felt_from_below(both, place, 0.001), 1.0 + radius * kStiffness, 0.01);
      }
      // Beyond the rim nothing must hold a hand.
      EXPECT_EQ(felt_from_above(both, {0.06, 0, 0}, 0.001), 0.0);
    }
}

/// A ball starts too near to a double-sided face. The face must push the ball to the ball's own
/// side.
TEST(DoubledFaces, ABallThatBeginsTooNearIsPushedToItsOwnSide) {
  const TriangleSoup sheet = test::sheet(0.05);
  for (const bool turned_first : {false, true})
    for (const double side : {1.0, -1.0}) {
      TriangleSoup soup{sheet.vertices, {}};
      for (const Triangle& t : sheet.triangles) {
        soup.triangles.push_back(turned_first ? turned(t) : t);
        soup.triangles.push_back(turned_first ? t : turned(t));
      }
      const Object both = test::mesh_object(soup, {.radius = 0.004}, {.stiffness = kStiffness});
      ContactMemory memory;
      const Command felt = touch(both, {Vec3(0.01, 0.012, side * 0.003), Vec3::Zero()}, memory);
      EXPECT_NEAR(side * felt.elastic.z(), 1.0, 1e-3) << side << turned_first;
    }
}

/// A Moebius strip has no consistent orientation.
TEST(DoubledFaces, AStripWithOneSideKeepsBoth) {
  constexpr int kAround = 16;
  TriangleSoup soup;
  for (int i = 0; i < kAround; ++i) {
    const double turn = 2.0 * M_PI * i / kAround, tilt = 0.5 * turn;
    for (const double half : {-0.01, 0.01}) {
      const double r = 0.05 + half * std::cos(tilt);
      soup.vertices.emplace_back(r * std::cos(turn), r * std::sin(turn), half * std::sin(tilt));
    }
  }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const bool last = i + 1 == kAround;
    const std::uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    for (const Triangle& t : {Triangle{a, b, d}, Triangle{a, d, c}}) {
      soup.triangles.push_back(t);
      soup.triangles.push_back(turned(t));
    }
  }
  EXPECT_EQ(TriangleMesh(soup).report().both_sides, 2u * kAround);
  EXPECT_EQ(TriangleMesh(soup, {}, true).report().both_sides, 2u * kAround);
}

/// A wall between two cells must agree with both cells.
TEST(DoubledFaces, AWallBetweenTwoCellsKeepsBothSides) {
  const TriangleSoup left = test::box(Vec3(0.01, 0.01, 0.01));
  TriangleSoup right = left;  // the mirror image beyond the wall
  for (Vec3& v : right.vertices) v.x() = 0.02 - v.x();
  for (Triangle& t : right.triangles) t = turned(t);
  const TriangleMesh mesh(test::joined(left, right));
  EXPECT_EQ(mesh.triangles().size(), 24u);
  EXPECT_EQ(mesh.report().both_sides, 2u);
}

TEST(DoubledFaces, CopiesThatFaceTheSameWayAreStillOnlyCounted) {
  TriangleSoup soup = test::icosphere(1.0, 1);
  soup.triangles.push_back(soup.triangles[7]);
  const TriangleMesh mesh(soup);
  EXPECT_EQ(mesh.report().duplicate, 1u);
  EXPECT_EQ(mesh.report().opposed, 0u);
  EXPECT_THAT(warnings(mesh.report(), true),
              AllOf(Contains(HasSubstr("stand twice; one of each was left out")),
                    Not(Contains(HasSubstr("turned over")))));
}

}  // namespace
}  // namespace feltwire::doubled_faces_test
