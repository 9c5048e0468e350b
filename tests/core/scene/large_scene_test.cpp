// Tests scenes and surfaces with many parts. A quadratic cost would take minutes and exceed the
// test's time limit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/dynamics/world.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/core/scene_text.hpp"

namespace feltwire::large_scene_test {
namespace {

using test::error_of;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kMany = 100000;

std::string numbered(const char* name, int i) { return name + std::to_string(i); }

/// Returns a list of part(0), part(1), ...
template <class Part>
std::string list(int count, const Part& part) {
  std::string text = "[";
  for (int i = 0; i < count; ++i) text += (i > 0 ? ",\n" : "") + part(i);
  return text + "]";
}

std::string box(const std::string& name, int place, const std::string& material) {
  return R"({"name":")" + name + R"(","box":{"size":[0.01,0.01,0.01]},"position":[)" +
         std::to_string(place % 400) + "," + std::to_string(place / 400) + R"(,0],"material":")" +
         material + R"("})";
}

std::string scene(const std::string& materials, const std::string& objects,
                  const std::string& more = "") {
  return R"({"name":"s",)" + more + R"("materials":)" + materials + R"(,"objects":)" + objects +
         "}";
}

const std::string kMaterial = R"([{"name":"m","stiffness":1000}])";

TEST(LargeScene, AHundredThousandBoxesLoadAndAreTouched) {
  const Scene many = parse_scene(
      scene(kMaterial, list(kMany, [](int i) { return box(numbered("b", i), i, "m"); })), "s.json");
  ASSERT_EQ(many.objects().size(), static_cast<std::size_t>(kMany));
  TouchMemory memory = many.memory();
  for (const int i : {0, 7, kMany - 1}) {
    const Vec3 above(i % 400, i / 400, 0.0051), in(i % 400, i / 400, 0.004);
    EXPECT_TRUE(many.touch({above, Vec3::Zero()}, memory).elastic.isZero(0.0)) << i;
    EXPECT_NEAR(many.touch({in, Vec3::Zero()}, memory).elastic.z(), 1.0, 1e-9) << i;
    EXPECT_TRUE(many.touch({above, Vec3::Zero()}, memory).elastic.isZero(0.0)) << i;
  }
}

TEST(LargeScene, OfAHundredThousandNamesTheOneThatStandsTwiceIsFound) {
  const std::string text = scene(kMaterial, list(kMany, [](int i) {
                                   return R"({"name":")" + numbered("o", i == kMany - 1 ? 17 : i) +
                                          R"(","plane":{},"material":"m"})";
                                 }));
  EXPECT_THAT(error_of(text),
              HasSubstr("objects[99999].name: 'o17' is the name of objects[17] too; rename one"));
}

TEST(LargeScene, FiftyThousandMaterialsAreFoundByTheirNames) {
  constexpr int kHalf = kMany / 2;
  const Scene many = parse_scene(
      scene(list(kHalf,
                 [](int i) {
                   return R"({"name":")" + numbered("m", i) + R"(","stiffness":)" +
                          std::to_string(1 + i) + "}";
                 }),
            list(kHalf,
                 [](int i) {
                   return R"({"name":")" + numbered("o", i) + R"(","plane":{},"material":")" +
                          numbered("m", kHalf - 1 - i) + R"("})";
                 })),
      "s.json");
  for (const std::size_t i : {std::size_t{0}, std::size_t{123}, std::size_t{kHalf - 1}})
    EXPECT_EQ(many.objects()[i].material.stiffness, static_cast<double>(kHalf - i));
}

/// Returns a disc as one face, with `corners` corners on its rim.
std::string disc(int corners, double height = 0.0) {
  std::string text;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * M_PI * i / corners;
    text += "v " + std::to_string(1e3 * std::cos(angle)) + " " +
            std::to_string(1e3 * std::sin(angle)) + " " + std::to_string(height) + "\n";
  }
  text += "f";
  for (int i = 1; i <= corners; ++i) text += " " + std::to_string(i);
  return text + "\n";
}

TEST(LargeScene, AFaceOfAHundredThousandCornersBecomesASurface) {
  TriangleMesh mesh(parse_obj(disc(kMany), "disc.obj", 1.0), 0.0);
  const MeshReport& report = mesh.report();
  const std::size_t count = mesh.triangles().size();
  // Rounding makes some triangles flat.
  EXPECT_GT(count, static_cast<std::size_t>(kMany) * 9 / 10);
  EXPECT_EQ(report.non_manifold_edges, 0u);
  EXPECT_EQ(report.turned_edges, 0u);
  // Every triangle of the fan must have two neighbours, except the two at the ends.
  std::size_t joined = 0;
  for (std::uint32_t t = 0; t < count; ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = mesh.neighbour(t, k);
      if (other == TriangleMesh::kNone) continue;
      ++joined;
      int back = 0;
      for (int l = 0; l < 3; ++l) back += mesh.neighbour(other, l) == t ? 1 : 0;
      ASSERT_EQ(back, 1) << t;
    }
  EXPECT_EQ(joined + report.boundary_edges, 3 * count);
  EXPECT_EQ(report.most_at_corner, count);
  EXPECT_THAT(warnings(report, false),
              ::testing::Contains(AllOf(HasSubstr(std::to_string(count)),
                                        HasSubstr("triangles meet at one corner"))));
}

TEST(LargeScene, OneTriangleAHundredThousandTimesIsOne) {
  TriangleSoup soup{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}, {}};
  // A reversed or rotated order still means this triangle.
  for (std::uint32_t i = 0; i < kMany; ++i)
    soup.triangles.push_back(i % 2 == 0 ? Triangle{i % 3, (i + 1) % 3, (i + 2) % 3}
                                        : Triangle{(i + 1) % 3, i % 3, (i + 2) % 3});
  soup.triangles.push_back({0, 1, 3});
  const TriangleMesh mesh(soup);
  EXPECT_EQ(mesh.triangles().size(), 2u);
  EXPECT_EQ(mesh.triangles()[0], (Triangle{2, 1, 0}));  // The neighbour has the edge from 0 to 1.
  EXPECT_EQ(mesh.report().duplicate, static_cast<std::size_t>(kMany - 1));
  EXPECT_EQ(mesh.report().boundary_edges, 4u);
}

/// Compares neighbours with their definition, for small surfaces with all kinds of edges.
TEST(LargeScene, NeighboursAreThoseThatShareAnEdgeTheOtherWayRound) {
  std::mt19937 random(11);
  for (int run = 0; run < 200; ++run) {
    TriangleSoup soup;
    for (int v = 0; v < 8; ++v) soup.vertices.emplace_back(v, v * v, v * v * v);
    for (int t = 0; t < 1 + run % 14; ++t) {
      std::array<std::uint32_t, 8> order{0, 1, 2, 3, 4, 5, 6, 7};
      std::shuffle(order.begin(), order.end(), random);
      soup.triangles.push_back({order[0], order[1], order[2]});
    }
    const TriangleMesh mesh(soup, 0.0);
    const auto& triangles = mesh.triangles();
    std::size_t open = 0, many = 0, turned = 0;
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[t][k], b = triangles[t][corner_after(k)];
        std::vector<std::uint32_t> others;
        bool agree = false;
        for (std::uint32_t u = 0; u < triangles.size(); ++u)
          for (std::size_t l = 0; u != t && l < 3; ++l) {
            const std::uint32_t c = triangles[u][l], d = triangles[u][corner_after(l)];
            if (!((c == a && d == b) || (c == b && d == a))) continue;
            others.push_back(u);
            agree = c == b;
          }
        // The two sides of a face are no neighbours. The face's edges are open and count once.
        const bool two_sides =
            others.size() == 1 && std::ranges::is_permutation(triangles[others[0]], triangles[t]);
        const bool good = others.size() == 1 && agree && !two_sides;
        ASSERT_EQ(mesh.neighbour(t, static_cast<int>(k)), good ? others[0] : TriangleMesh::kNone);
        const bool counts = std::ranges::all_of(others, [&](std::uint32_t u) { return u > t; });
        open += others.empty() || (two_sides && t < others[0]) ? 1 : 0;
        many += counts && others.size() > 1 ? 1 : 0;
        turned += counts && others.size() == 1 && !agree ? 1 : 0;
      }
    EXPECT_EQ(mesh.report().boundary_edges, open);
    EXPECT_EQ(mesh.report().non_manifold_edges, many);
    EXPECT_EQ(mesh.report().turned_edges, turned);
  }
}

std::string bodies(int count, const std::string& joint) {
  return R"("bodies":)" +
         list(count,
              [&](int i) {
                return R"({"name":")" + numbered("k", i) + R"(","mass":1,"position":[)" +
                       std::to_string(i % 50) + "," + std::to_string(i / 50) + ",1]" + joint + "}";
              }) +
         ",";
}
std::string bodies_scene(int count, const std::string& joint = "") {
  return scene(kMaterial,
               list(count,
                    [](int i) {
                      return R"({"name":")" + numbered("o", i) + R"(","body":")" +
                             numbered("k", i) + R"(","box":{"size":[0.1,0.1,0.1]},"material":"m"})";
                    }),
               bodies(count, joint));
}

TEST(LargeScene, TwoThousandBodiesLoadAndFall) {
  const Scene many = parse_scene(bodies_scene(2000), "s.json");
  ASSERT_NE(many.mechanism(), nullptr);
  EXPECT_EQ(many.mechanism()->parts().size(), 2000u);
  EXPECT_THAT(many.warnings(), IsEmpty());
  World world(many);
  world.step();
  EXPECT_NEAR(world.momentum().z(), -2000.0 * 9.81 * kDefaultTick, 1e-6);
}

TEST(LargeScene, TooManyBodiesAreRefusedWithTheLimit) {
  EXPECT_THAT(
      error_of(bodies_scene(4001)),
      HasSubstr("bodies: must be at most 4000 that move, are 4001; have fewer, or fix those "
                "that need not move"));
}

TEST(LargeScene, BodiesThatTakeMoreThanMujocoHasAreRefusedWithTheReason) {
  EXPECT_THAT(
      error_of(bodies_scene(3900, R"(,"joint":"hinge","range":[-1,1],"friction":0.1)")),
      AllOf(HasSubstr("bodies: the 3900 bodies, 3900 of them with a range or friction, take "),
            HasSubstr(" at once in MuJoCo, which takes at most 2 GB; have fewer bodies")));
}

}  // namespace
}  // namespace feltwire::large_scene_test
