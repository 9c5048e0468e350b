#pragma once
// Tools with a body, and the objects that they touch, for tests.

#include "core/grid/signed_distance.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire::test {

inline const Vec3 kHalf(0.03, 0.02, 0.01);             // [m] of the box that most tests hold
inline constexpr double kFace = 4.0 * 0.03 * 0.02;     // [m^2] its lower face
inline constexpr double kRound = 4.0 * (0.03 + 0.02);  // [m] its circumference
inline constexpr double kStiffness = 1000.0;           // [N/m]

/// [N] The face and the sides below the plane, pressed in by d: k / A_c (A d + P d^2 / 2).
inline double flat_force(double d, double area) {
  return kStiffness / area * (kFace * d + 0.5 * kRound * d * d);
}

inline PointShell box_shell(std::size_t count) {
  return point_shell(tessellate(Box{kHalf}, 3), count);
}

inline Object object(const Shape& shape, const Vec3& position = Vec3::Zero()) {
  Object o;
  o.name = "o";
  o.shape = shape;
  o.pose.position = position;
  o.material.stiffness = kStiffness;
  return o;
}

inline Grid grid_of(const Shape& shape, double resolution) {
  return {std::make_shared<DistanceGrid<float>>(solid_of(shape),
                                                GridOptions{.resolution = resolution})};
}

inline BodyTool tool(std::size_t points = 2000, const ToolCoupling& coupling = {}) {
  return {box_shell(points), coupling, kFace};
}

/// A step of 1 ms, with nothing moving.
inline BodyStep step(const BodyTool& tool, std::span<const Object> objects, const Pose& device,
                     BodyMemory& memory) {
  return step_body(tool, objects, device, 1e-3, memory);
}

/// [J] in the coupling between tool and device.
inline double coupling_energy(const BodyTool& body, const Pose& tool, const Pose& device) {
  const ToolCoupling& k = body.coupling();
  const auto huber = [](double x, double stiffness, double most) {
    return x < most / stiffness ? 0.5 * stiffness * x * x : most * (x - 0.5 * most / stiffness);
  };
  return huber((device.position - tool.position).norm(), k.stiffness, k.max_force) +
         huber(rotation_between(tool.orientation, device.orientation).norm(),
               k.rotational_stiffness, k.max_torque);
}

}  // namespace feltwire::test
