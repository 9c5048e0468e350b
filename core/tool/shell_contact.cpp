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
  Vec6 wrench = Vec6::Zero();
  Mat6 stiffness = Mat6::Zero();  // its lower triangle

  void add(const FieldPoint& field, const Vec3& arm) {
    squares += field.distance * field.distance;
    Vec6 direction;
    direction << field.gradient, arm.cross(field.gradient);
    wrench -= field.distance * direction;
    for (Eigen::Index i = 0; i < direction.size(); ++i)
      stiffness.col(i).tail(direction.size() - i) +=
          direction[i] * direction.tail(direction.size() - i);
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
  Mat6 rotation = Mat6::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = to_world;
  sum.wrench += scale * (rotation * sums.wrench);
  const Mat6 whole = sums.stiffness.selfadjointView<Eigen::Lower>();
  sum.stiffness += scale * (rotation * whole * rotation.transpose());
}

}  // namespace feltwire
