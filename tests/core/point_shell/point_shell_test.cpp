// Tests the points of a tool with a body, and their tree.

#include "core/point_shell/point_shell.hpp"

#include <gtest/gtest.h>

#include "tests/core/bodies.hpp"

namespace feltwire::point_shell_test {
namespace {

using test::box_shell;
using test::kHalf;

TEST(PointShell, IsEvenOverTheSurface) {
  const std::size_t count = 6000;
  const PointShell shell = box_shell(count);
  ASSERT_EQ(shell.points.size(), count);
  EXPECT_NEAR(shell.area, 8.0 * (0.03 * 0.02 + 0.02 * 0.01 + 0.03 * 0.01), 1e-12);
  Vec3 middle = Vec3::Zero();
  std::array<int, 3> on{};  // counts on the faces across x, y, z
  for (const Vec3& p : shell.points) {
    middle += p / static_cast<double>(count);
    const Vec3 beyond = p.cwiseAbs() - kHalf;
    EXPECT_NEAR(beyond.maxCoeff(), 0.0, 1e-15);
    for (int axis = 0; axis < 3; ++axis)
      on[static_cast<std::size_t>(axis)] += beyond[axis] > -1e-12 ? 1 : 0;
  }
  EXPECT_LT(middle.norm(), 1e-4);
  EXPECT_NEAR(on[0], count * 2 / 11, 2);  // 2 of 11 parts of the total area
  EXPECT_NEAR(on[1], count * 3 / 11, 2);
  EXPECT_NEAR(on[2], count * 6 / 11, 2);
  // The points must leave no hole: each position on the large face has a point within three mean
  // distances.
  const double near = 3.0 * std::sqrt(shell.area / static_cast<double>(count));
  for (double x = -0.03; x <= 0.03; x += 0.003)
    for (double y = -0.02; y <= 0.02; y += 0.004) {
      double nearest = 1.0;
      for (const Vec3& p : shell.points) nearest = std::min(nearest, (p - Vec3(x, y, 0.01)).norm());
      EXPECT_LT(nearest, near);
    }
}

TEST(PointShell, ItsTreeHoldsEveryPointOnce) {
  for (const std::size_t count : {1u, 7u, 8u, 9u, 64u, 65u, 1000u, 4099u}) {
    const PointShell shell = box_shell(count);
    std::vector<int> seen(count, 0), reached(shell.nodes.size(), 0);
    reached[0] = 1;
    std::size_t leaves = 0;
    for (std::size_t n = 0; n < shell.nodes.size(); ++n) {
      const ShellNode& node = shell.nodes[n];
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        EXPECT_LE((shell.points[i] - node.center).norm(), node.radius * (1.0 + 1e-12));
      std::uint32_t at = node.begin;
      for (std::uint32_t c = node.child; c < node.child + node.children; ++c) {
        ASSERT_GT(c, n);
        ++reached[c];
        EXPECT_EQ(shell.nodes[c].begin, at);
        at = shell.nodes[c].end;
      }
      if (node.children != 0) {
        EXPECT_EQ(at, node.end);
        EXPECT_LE(node.children, ShellNode::kParts);
        continue;
      }
      ++leaves;
      ASSERT_LE(node.end - node.begin, ShellNode::kParts);
      for (std::uint32_t i = node.begin; i < node.end; ++i) ++seen[i];
    }
    for (const int times : seen) EXPECT_EQ(times, 1);
    for (const int times : reached) EXPECT_EQ(times, 1);
    EXPECT_EQ(leaves, (count + 7) / 8);  // All leaves except the last are full.
  }
}

TEST(PointShell, RefusesNothingAndTooMuch) {
  const TriangleSoup box = tessellate(Box{kHalf}, 3);
  EXPECT_THROW(point_shell(box, 0), std::invalid_argument);
  EXPECT_THROW(point_shell(box, kMaxShellPoints + 1), std::invalid_argument);
  TriangleSoup flat = box;
  for (Vec3& v : flat.vertices) v.setZero();
  EXPECT_THROW(point_shell(flat, 10), std::invalid_argument);
  EXPECT_EQ(point_shell(box, 1).points.size(), 1u);
}

}  // namespace
}  // namespace feltwire::point_shell_test
