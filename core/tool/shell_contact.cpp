#include "core/tool/shell_contact.hpp"

#include <algorithm>
#include <array>

#include "core/geometry/signed_distance.hpp"

namespace feltwire {
namespace {

/// A ball of points is left out where it is farther from the surface than this part of its radius:
/// a smaller one would leave little that is sure of their distance, for the clearance.
constexpr double kFarEnough = 0.5;

double far_of(const ShellNode& node) { return (1.0 + kFarEnough) * node.radius; }

using Lanes = FieldGroup::Lanes;
static_assert(ShellNode::kParts == FieldGroup::kSize);

/// Sums in the object's frame, arms from the tool's origin.
struct Sums {
  double squares = 0.0;  // of distances [m^2]
  Vec6 wrench = Vec6::Zero();
  Mat6 stiffness = Mat6::Zero();  // the lower half

  /// Of the places whose distance is below zero, the others' being zero with their gradient.
  void add(const FieldGroup& group, const std::array<Lanes, 3>& arm) {
    const std::array<Lanes, 6> way = {group.gradient_x,
                                      group.gradient_y,
                                      group.gradient_z,
                                      arm[1] * group.gradient_z - arm[2] * group.gradient_y,
                                      arm[2] * group.gradient_x - arm[0] * group.gradient_z,
                                      arm[0] * group.gradient_y - arm[1] * group.gradient_x};
    squares += group.distance.square().sum();
    for (std::size_t i = 0; i < way.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      wrench[row] -= (group.distance * way[i]).sum();
      for (std::size_t k = 0; k <= i; ++k)
        stiffness(row, static_cast<Eigen::Index>(k)) += (way[i] * way[k]).sum();
    }
  }
};

/// One shell against one object, in the object's frame.
struct Look {
  const PointShell& shell;
  const Object& object;
  Mat3 turned;  // the tool's frame into the object's
  Vec3 origin;  // [m] of the tool
  ShellContact& sum;
  Sums sums = {};

  /// Whether the ball may come near; notes how far away it is where it does not.
  bool near(const ShellNode& node, double distance) {
    if (!(distance > far_of(node))) return true;
    sum.clearance = std::min(sum.clearance, distance - node.radius);
    return false;
  }

  bool root_is_near() {
    const ShellNode& all = shell.nodes[0];
    ++sum.looked_at;
    return near(all, distance_at_least(object.shape, object.felt_from, origin + turned * all.center,
                                       far_of(all)));
  }

  void points(const ShellNode& leaf) {
    const std::size_t count = leaf.end - leaf.begin;
    FieldGroup group;
    std::array<Lanes, 3> arm;
    for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane) {
      const Vec3& p = shell.points[leaf.begin + std::min(lane, count - 1)];
      const auto l = static_cast<Eigen::Index>(lane);
      for (std::size_t axis = 0; axis < arm.size(); ++axis) {
        const auto a = static_cast<Eigen::Index>(axis);
        arm[axis][l] = turned(a, 0) * p.x() + turned(a, 1) * p.y() + turned(a, 2) * p.z();
      }
    }
    group.x = origin.x() + arm[0];
    group.y = origin.y() + arm[1];
    group.z = origin.z() + arm[2];
    signed_distance(object.shape, object.felt_from, group);
    sum.looked_at += count;
    Lanes inside;
    std::size_t touching = 0;
    for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane) {
      const auto l = static_cast<Eigen::Index>(lane);
      const double distance = group.distance[l];
      const bool in = lane < count && distance < 0.0;
      inside[l] = in ? 1.0 : 0.0;
      touching += in ? 1 : 0;
      if (!in && lane < count) sum.clearance = std::min(sum.clearance, distance);
    }
    if (touching == 0) return;
    sum.touching += touching;
    group.distance *= inside;
    group.gradient_x *= inside;
    group.gradient_y *= inside;
    group.gradient_z *= inside;
    sums.add(group, arm);
  }

  void all() {
    // A node's children stand on the stack only while it is looked into.
    std::array<std::uint32_t, kMaxShellDepth * ShellNode::kParts> waiting;
    std::size_t count = 0;
    if (root_is_near()) waiting[count++] = 0;
    while (count > 0) {
      const ShellNode& node = shell.nodes[waiting[--count]];
      if (node.children == 0) {
        points(node);
        continue;
      }
      FieldGroup group;
      Lanes far;
      for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane) {
        const ShellNode& child =
            shell.nodes[node.child + std::min<std::size_t>(lane, node.children - 1)];
        group.put(lane, origin + turned * child.center);
        far[static_cast<Eigen::Index>(lane)] = far_of(child);
      }
      distance_at_least(object.shape, object.felt_from, group, far);
      sum.looked_at += node.children;
      for (std::size_t lane = node.children; lane-- > 0;) {  // the first will be on top
        const auto child = node.child + static_cast<std::uint32_t>(lane);
        if (near(shell.nodes[child], group.distance[static_cast<Eigen::Index>(lane)]))
          waiting[count++] = child;
      }
    }
  }
};

}  // namespace

void add_contact(const PointShell& shell, const Pose& tool, const Object& object,
                 double contact_area, ShellContact& sum) noexcept {
  const Mat3 to_world = object.pose.orientation.toRotationMatrix();
  Look look{shell, object, to_world.transpose() * tool.orientation.toRotationMatrix(),
            to_world.transpose() * (tool.position - object.pose.position), sum};
  look.all();
  const Sums& sums = look.sums;
  if (!(sums.squares > 0.0)) return;

  const double scale = object.material.stiffness * shell.area /
                       (contact_area * static_cast<double>(shell.points.size()));
  sum.energy += 0.5 * scale * sums.squares;
  sum.wrench.head<3>() += scale * (to_world * sums.wrench.head<3>());
  sum.wrench.tail<3>() += scale * (to_world * sums.wrench.tail<3>());
  const Mat6 stiffness = sums.stiffness.selfadjointView<Eigen::Lower>();
  for (const Eigen::Index row : {0, 3})
    for (const Eigen::Index column : {0, 3})
      sum.stiffness.block<3, 3>(row, column) +=
          scale * (to_world * stiffness.block<3, 3>(row, column) * to_world.transpose());
}

}  // namespace feltwire
