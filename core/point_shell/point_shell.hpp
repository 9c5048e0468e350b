#pragma once
// A tool's body as points on its surface (McNeely, Puterbaugh & Troy, Six degree-of-freedom haptic
// rendering using voxel sampling, SIGGRAPH 1999). The points lie in a tree of balls, so that a
// query leaves out whole groups of points that are far from everything.

#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/triangle_soup.hpp"

namespace feltwire {

/// A part of the shell: the points [begin, end), the ball that holds them, and its parts.
struct ShellNode {
  static constexpr std::uint32_t kParts =
      8;                       // largest number of children of a node and of points of a leaf
  Vec3 center = Vec3::Zero();  // [m, tool frame]
  double radius = 0.0;         // [m]
  std::uint32_t begin = 0, end = 0;
  std::uint32_t child = 0, children = 0;  // nodes [child, child + children); none: a leaf
};

struct PointShell {
  std::vector<Vec3> points;      // [m, tool frame] in the order of the tree's leaves
  std::vector<ShellNode> nodes;  // the first holds all
  double area = 0.0;             // [m^2] of the whole surface; each point stands for the same share
  double radius = 0.0;           // [m] of the farthest point from the tool's origin
  /// These points, grouped by the axis of the tool's frame that the surface's normal is nearest to:
  /// at most six shells, without sides of their own.
  std::vector<PointShell> sides;
};

/// `count` points spread evenly over the area of the surface. Deterministic. Throws
/// std::invalid_argument if there is no area, or the count is zero or above kMaxShellPoints.
PointShell point_shell(const TriangleSoup& surface, std::size_t count);
/// A shell of these points [m, tool frame] on a surface of so much area [m^2], without its sides.
/// Precondition: 1 to kMaxShellPoints finite points.
PointShell point_shell(std::vector<Vec3> points, double area);

inline constexpr std::size_t kMaxShellPoints = 1'000'000;
inline constexpr std::size_t kMaxShellDepth = 8;  // of the tree of so many points

}  // namespace feltwire
