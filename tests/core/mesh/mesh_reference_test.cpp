// Checks the proxy on random meshes against all triangles. The proxy must be on the surface, and no
// point of a touched triangle may be nearer to the tool. The proxy must hold the tool exactly while
// the tool is inside the solid.

#include <gtest/gtest.h>

#include <cmath>

#include "core/contact/contact.hpp"
#include "core/geometry/half_spaces.hpp"
#include "core/mesh/mesh_contact.hpp"
#include "tests/core/support.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::mesh_reference_test {
namespace {

/// Returns a sphere of 0.1 m with randomly moved corners. The sphere has as many ridges as valleys.
TriangleSoup bumpy(std::uint64_t seed, double least) {
  TriangleSoup soup = test::icosphere(0.1, 3);
  test::Random random(seed);
  for (Vec3& v : soup.vertices) v *= random.uniform(least, 1.0);
  return soup;
}

/// Returns true if a ray from p crosses the surface an odd number of times.
bool is_inside(const MeshSurface& surface, const Vec3& p) {
  const Vec3 far = p + Vec3(0.513, 0.327, 0.811);
  int crossings = 0;
  for (std::uint32_t t = 0; t < surface.mesh().triangles().size(); ++t)
    for (const std::int8_t side : {std::int8_t{1}, std::int8_t{-1}})
      crossings += surface.crossing(t, p, far, side).has_value();
  return crossings % 2 == 1;
}

/// Moves a hand in, out and around.
template <class Visit>
void wander(std::uint64_t seed, double step, int samples, Visit visit) {
  test::Random random(seed);
  Vec3 p(0.0, 0.0, 0.13), v = Vec3::Zero();
  for (int n = 0; n < samples; ++n) {
    v = 0.9 * v + 0.3 * step * random.direction() -
        0.1 * step * (p.norm() - 0.088) / 0.01 * p.normalized();
    p += v;
    visit(n, p);
  }
}

TEST(MeshReference, APointsProxyIsTheNearestOfAllItTouches) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const MeshSurface surface{TriangleMesh(bumpy(seed, 0.9))};
    FeatureMemory memory;
    int held = 0, on_edges = 0;
    wander(seed, seed % 2 == 0 ? 2e-3 : 5e-4, 1500, [&](int n, const Vec3& p) {
      const SurfacePoint found = mesh_surface_point(surface, Side::outside, p, memory);
      const Vec3 goal = p - surface.mesh().origin();
      if (memory.side == 0) {
        ASSERT_FALSE(is_inside(surface, goal)) << seed << " " << n;
        return;
      }
      if (!(found.depth > 0.0)) return;
      ++held;
      const Vec3 proxy = memory.proxy;
      double nearest = 1.0;
      int touched = 0;
      for (std::uint32_t t = 0; t < surface.mesh().triangles().size(); ++t) {
        const auto corners = surface.mesh().corners(t);
        const double away = (nearest_on_triangle(corners, proxy).point - proxy).norm();
        nearest = std::min(nearest, away);
        if (away > 1e-12) continue;
        ++touched;
        const double best = (nearest_on_triangle(corners, goal).point - goal).norm();
        ASSERT_GE(best, found.depth - 1e-9) << seed << " " << n << " " << t;
      }
      ASSERT_LE(nearest, 2.0 * surface.skin()) << seed << " " << n;
      on_edges += touched > 1;
      ASSERT_NEAR((found.normal * found.depth - (proxy - goal)).norm(), 0.0, 1e-9);
    });
    EXPECT_GT(held, 700) << seed;
    EXPECT_GT(on_edges, 20) << seed;
  }
}

TEST(MeshReference, ABallTouchesNoTriangleDeeperAndIsNoNearerThanTheyLet) {
  constexpr double kRadius = 0.004;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const MeshSurface surface{TriangleMesh(bumpy(seed, 0.93)), {.radius = kRadius}};
    FeatureMemory memory;
    int held = 0, stuck = 0;
    wander(seed, 5e-4, 1200, [&](int n, const Vec3& p) {
      mesh_surface_point(surface, Side::outside, p, memory);
      const Vec3 goal = p - surface.mesh().origin(), proxy = memory.proxy;
      std::vector<HalfSpace> holding;
      for (std::uint32_t t = 0; t < surface.mesh().triangles().size(); ++t) {
        const Vec3 q = nearest_on_triangle(surface.mesh().corners(t), proxy).point;
        const double away = (proxy - q).norm();
        ASSERT_GE(away, kRadius * (1.0 - 1e-5)) << seed << " " << n << " " << t;
        if (away > kRadius * (1.0 + 1e-4)) continue;
        const Vec3 normal = (proxy - q) / away;
        holding.push_back({normal, normal.dot(proxy)});
      }
      const double depth = (proxy - goal).norm();
      if (!(depth > 1e-6)) return;
      ++held;
      // The triangles that hold the ball must allow no nearer position.
      const NearestPoint aim = nearest_in(holding, goal, 1e-12);
      stuck += !aim.found || (aim.point - proxy).norm() > 0.02 * depth + 1e-6;
    });
    EXPECT_GT(held, 400) << seed;
    EXPECT_LE(stuck, held / 100) << seed;
  }
}

}  // namespace
}  // namespace feltwire::mesh_reference_test
