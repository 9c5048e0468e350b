#include "core/point_shell/shell_contact.hpp"

#include <algorithm>
#include <array>

#include "core/base/numeric.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/point_shell/object_motion.hpp"
#include "core/tool_coupling/slip_sums.hpp"

namespace feltwire {
namespace {

/// The search skips a ball of points if its distance from the surface, as a share of its radius, is
/// above this value. A smaller value would give a weaker bound of the clearance.
constexpr double kFarEnough = 0.5;

constexpr std::uint64_t kGroupWork = 4;  // units of work per eight queries

double far_of(const ShellNode& node) { return (1.0 + kFarEnough) * node.radius; }

using Lanes = FieldGroup::Lanes;
static_assert(ShellNode::kParts == FieldGroup::kSize);

/// Sums of a contact in the object frame. The arms start at the tool's origin.
struct Sums {
  double squares = 0.0;  // [m^2] sum of squared distances
  Vec6 wrench = Vec6::Zero();
  Mat6 stiffness = Mat6::Zero();  // lower triangle

  /// Adds the points with a negative distance. All other points have zero distance and gradient.
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

/// Sums over the points of a friction patch, weighted by the load d |grad d|.
struct FrictionPatchSums : SlipSums {
  void add(const Lanes& weights, const std::array<Lanes, 3>& normals,
           const std::array<Lanes, 3>& arm_of) {
    weight += weights.sum();
    for (std::size_t i = 0; i < arm_of.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const Lanes weighted = weights * arm_of[i];
      arm[row] += weighted.sum();
      normal[row] += (weights * normals[i]).sum();
      for (std::size_t k = 0; k <= i; ++k)
        arms(row, static_cast<Eigen::Index>(k)) += (weighted * arm_of[k]).sum();
    }
  }
};

/// The side of a normal is the nearest axis of the object frame. The angle to this axis is at most
/// 55 degrees.
constexpr std::size_t kPatchSides = 6;
std::size_t side_of(const Vec3& way) {
  Eigen::Index axis;
  way.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<std::size_t>(axis) + (way[axis] < 0.0 ? 1 : 0);
}

/// A query of a shell against an object, in the object's frame.
struct ShellQuery {
  const PointShell& shell;
  const Object& object;
  Mat3 turned;  // rotation from the tool frame to the object frame
  Vec3 origin;  // [m] position of the tool's origin
  ShellContact& sum;
  bool slides;  // true if the slip sums are computed
  WorkLimit* work;
  Sums sums = {};
  std::array<FrictionPatchSums, kPatchSides> patches = {};

  /// Returns true if the node's ball may be near the surface. Otherwise, limits the clearance by
  /// the ball's distance.
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
    if (slides && may_go_on(work, kGroupWork)) slip(group, arm);
  }

  void slip(const FieldGroup& group, const std::array<Lanes, 3>& arm) {
    const Lanes length =
        (group.gradient_x.square() + group.gradient_y.square() + group.gradient_z.square()).sqrt();
    const Lanes load = -group.distance * length;
    std::array<Lanes, kPatchSides> weights;
    weights.fill(Lanes::Zero());
    std::array<Lanes, 3> normals;
    normals.fill(Lanes::Zero());
    std::array<bool, kPatchSides> there{};
    for (Eigen::Index l = 0; l < load.size(); ++l) {
      if (!(load[l] > 0.0)) continue;
      const Vec3 way(group.gradient_x[l], group.gradient_y[l], group.gradient_z[l]);
      const std::size_t side = side_of(way);
      weights[side][l] = load[l];
      there[side] = true;
      for (std::size_t axis = 0; axis < normals.size(); ++axis)
        normals[axis][l] = way[static_cast<Eigen::Index>(axis)] / length[l];
    }
    for (std::size_t side = 0; side < kPatchSides; ++side)
      if (there[side]) patches[side].add(weights[side], normals, arm);
  }

  /// Adds the friction patches. `scale` [N] is the force per unit of load.
  void patch(const Mat3& to_world, double scale, const ObjectInStep& in) {
    const Material& material = object.material;
    double whole = 0.0;
    for (const FrictionPatchSums& g : patches) whole += g.weight;
    for (const FrictionPatchSums& g : patches) {
      if (!(g.weight > 0.0)) continue;
      const Mat6 slip = turned_by(to_world, g.slip());
      const double viscous = in.share * material.viscous_friction * g.weight / whole;
      sum.viscosity.add(viscous * slip, in.carried);
      if (!(material.static_friction > 0.0)) continue;
      const double load = scale * g.weight;
      if (sum.grip_count == ShellContact::kFrictionPatches) {
        sum.patches.back().load += load;
        continue;
      }
      sum.patches[sum.grip_count++] = {
          load, material.static_friction, material.dynamic_friction, slip, in.carried, in.index};
    }
  }

  void all() {
    // The stack contains the children of a node only while the node is processed.
    std::array<std::uint32_t, kMaxShellDepth * ShellNode::kParts> waiting;
    std::size_t count = 0;
    if (root_is_near()) waiting[count++] = 0;
    while (count > 0 && may_go_on(work, kGroupWork)) {
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
      for (std::size_t lane = node.children; lane-- > 0;) {  // The first child will be on top.
        const auto child = node.child + static_cast<std::uint32_t>(lane);
        if (near(shell.nodes[child], group.distance[static_cast<Eigen::Index>(lane)]))
          waiting[count++] = child;
      }
    }
  }
};

}  // namespace

void add_contact(const PointShell& shell, const Pose& tool, const Object& object,
                 double contact_area, ShellContact& sum, const ObjectInStep& in,
                 WorkLimit* work) noexcept {
  if (!may_go_on(work, kGroupWork)) return;
  const Material& material = object.material;
  const Mat3 to_world = object.pose.orientation.toRotationMatrix();
  ShellQuery look{shell,
                  object,
                  to_world.transpose() * tool.orientation.toRotationMatrix(),
                  to_world.transpose() * (tool.position - object.pose.position),
                  sum,
                  material.static_friction > 0.0 || material.viscous_friction > 0.0,
                  work};
  look.all();
  const Sums& sums = look.sums;
  if (!(sums.squares > 0.0)) return;

  const double share = shell.area / (contact_area * static_cast<double>(shell.points.size()));
  const double scale = in.share * material.stiffness * share;
  sum.energy += 0.5 * scale * sums.squares;
  Vec6 wrench;
  wrench << to_world * sums.wrench.head<3>(), to_world * sums.wrench.tail<3>();
  wrench *= scale;
  sum.wrench += wrench;
  if (sum.part_count < ShellContact::kFrictionPatches)
    sum.parts[sum.part_count++] = {in.index, wrench};
  else
    sum.parts.back().wrench += wrench;
  const Mat6 normal = turned_by(to_world, Mat6(sums.stiffness.selfadjointView<Eigen::Lower>()));
  sum.stiffness += scale * normal;
  if (material.damping > 0.0)
    sum.damping.add(in.share * material.damping * share * normal, in.carried);
  if (look.slides) look.patch(to_world, scale, in);
}

}  // namespace feltwire
