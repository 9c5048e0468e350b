#include "core/tool/shell_contact.hpp"

#include <algorithm>

#include "core/geometry/signed_distance.hpp"

namespace feltwire {
namespace {

/// A ball of points is left out where it is farther from the surface than this part of its radius:
/// a smaller one would leave little that is sure of their distance, for the clearance.
constexpr double kFarEnough = 0.5;

/// Sums in the object's frame, arms from the tool's origin.
struct Sums {
  double squares = 0.0;  // of distances [m^2]
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  // Of the stiffness: translation, rotation, and rotation by translation.
  Mat3 linear = Mat3::Zero(), rotational = Mat3::Zero(), mixed = Mat3::Zero();

  void add(const FieldPoint& field, const Vec3& arm) {
    const Vec3& way = field.gradient;
    const Vec3 moment = arm.cross(way);
    squares += field.distance * field.distance;
    force -= field.distance * way;
    torque -= field.distance * moment;
    linear += way * way.transpose();
    rotational += moment * moment.transpose();
    mixed += moment * way.transpose();
  }
};

}  // namespace

void add_contact(const PointShell& shell, const Pose& tool, const Object& object,
                 double contact_area, ShellContact& sum) noexcept {
  const Mat3 to_world = object.pose.orientation.toRotationMatrix();
  const Mat3 turned = to_world.transpose() * tool.orientation.toRotationMatrix();
  const Vec3 origin = to_world.transpose() * (tool.position - object.pose.position);

  Sums sums;
  for (std::size_t n = 0; n < shell.nodes.size();) {
    const ShellNode& node = shell.nodes[n];
    const Vec3 center = origin + turned * node.center;
    const double far = (1.0 + kFarEnough) * node.radius;
    const double distance = distance_at_least(object.shape, object.felt_from, center, far);
    const double nearest = distance - node.radius;
    ++sum.looked_at;
    if (distance > far) {
      sum.clearance = std::min(sum.clearance, nearest);
      n = node.next;
      continue;
    }
    ++n;
    if (node.next != n) continue;  // its points are looked at below
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const Vec3 arm = turned * shell.points[i];
      const FieldPoint field = signed_distance(object.shape, object.felt_from, origin + arm);
      ++sum.looked_at;
      if (field.distance < 0.0) {
        sums.add(field, arm);
        ++sum.touching;
      } else {
        sum.clearance = std::min(sum.clearance, field.distance);
      }
    }
  }
  if (!(sums.squares > 0.0)) return;

  const double scale = object.material.stiffness * shell.area /
                       (contact_area * static_cast<double>(shell.points.size()));
  sum.energy += 0.5 * scale * sums.squares;
  const auto turn = [&](const Mat3& m) -> Mat3 { return to_world * m * to_world.transpose(); };
  const Mat3 mixed = scale * turn(sums.mixed);
  sum.wrench.head<3>() += scale * (to_world * sums.force);
  sum.wrench.tail<3>() += scale * (to_world * sums.torque);
  sum.stiffness.topLeftCorner<3, 3>() += scale * turn(sums.linear);
  sum.stiffness.bottomRightCorner<3, 3>() += scale * turn(sums.rotational);
  sum.stiffness.bottomLeftCorner<3, 3>() += mixed;
  sum.stiffness.topRightCorner<3, 3>() += mixed.transpose();
}

}  // namespace feltwire
