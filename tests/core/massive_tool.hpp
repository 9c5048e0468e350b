#pragma once
// A box with mass in a hand, for tests.

#include <utility>
#include <vector>

#include "tests/core/bodies.hpp"

namespace feltwire::test {

inline constexpr double kGravity = 9.81;  // [m/s^2]
inline constexpr double kStep = 1e-3;     // [s]

/// [kg m^2] of a solid box of half extents kHalf: m / 3 (b^2 + c^2) about each axis.
inline Mat3 box_inertia(double mass) {
  const Vec3 squares = kHalf.cwiseProduct(kHalf);
  return mass / 3.0 * (Vec3::Constant(squares.sum()) - squares).asDiagonal().toDenseMatrix();
}

/// A box of this mass, with the rest from `inertia`.
inline BodyTool massive(double mass, const ToolCoupling& coupling, ToolInertia inertia,
                        std::size_t points = 100) {
  inertia.mass = mass;
  inertia.inertia = box_inertia(mass);
  return {box_shell(points), coupling, kFace, inertia};
}

/// A tool in a hand among fixed objects.
struct Massive {
  explicit Massive(BodyTool of, std::vector<Object> among = {})
      : tool(std::move(of)), objects(std::move(among)) {}

  BodyTool tool;
  std::vector<Object> objects;
  BodyMemory memory = {};

  /// Puts the tool at rest at a pose.
  void place(const Pose& pose) {
    memory = {};
    memory.placed = true;
    memory.pose = pose;
  }
  BodyStep step(const Pose& device, double elapsed = kStep) {
    return step_body(tool, objects, device, elapsed, memory);
  }
  /// [J] in the spring, with the device at another pose.
  double coupling_at(const Pose& device) const {
    return coupling_energy(tool, memory.pose, device);
  }
  /// [J] potential of gravity.
  double weight() const {
    const ToolInertia& i = tool.inertia();
    return -i.mass * i.gravity.dot(center_of_mass(i, memory.pose));
  }
  /// [N], [N m] of the spring on the tool.
  Vec6 spring(const Pose& device) const {
    const ToolCoupling& c = tool.coupling();
    const auto limited = [](const Vec3& stretch, double stiffness, double most) {
      const double size = stiffness * stretch.norm();
      return Vec3(size > most ? most / size * stiffness * stretch : stiffness * stretch);
    };
    Vec6 wrench;
    wrench << limited(device.position - memory.pose.position, c.stiffness, c.max_force),
        limited(rotation_between(memory.pose.orientation, device.orientation),
                c.rotational_stiffness, c.max_torque);
    return wrench;
  }
};

}  // namespace feltwire::test
