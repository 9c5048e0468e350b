#include "sim/measure/surfaces.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {

SurfaceDistance plane_distance(const Vec3& point) { return {point.z(), Vec3::UnitZ()}; }

SurfaceDistance sphere_distance(const Vec3& point, double radius) {
  return {point.norm() - radius, direction(point)};
}

SurfaceDistance corner_distance(const Vec3& point) {
  const Vec3 out = (-point).cwiseMax(0.0);  // vector to the nearest point of the free octant
  const double depth = out.norm();
  if (depth > 0.0) return {-depth, out / depth};
  Eigen::Index axis;
  const double distance = point.minCoeff(&axis);
  return {distance, Vec3::Unit(axis)};
}

ContactNormals corner_walls(const Vec3& point) {
  ContactNormals walls;
  for (const Vec3& normal : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())})
    if (point.dot(normal) < 0.0) walls.add(normal);
  return walls;
}

SurfaceDistance edge_distance(const Vec3& point) {
  const Vec3 out = Vec3(point.x(), point.y(), 0.0).cwiseMax(0.0);
  const double distance = out.norm();
  if (distance > 0.0) return {distance, out / distance};
  return point.x() > point.y() ? SurfaceDistance{point.x(), Vec3::UnitX()}
                               : SurfaceDistance{point.y(), Vec3::UnitY()};
}

ImplicitValue bumpy_torus(const BumpyTorus& torus, const Vec3& point) {
  const double rho = std::hypot(point.x(), point.y());
  const double beyond = rho - torus.ring;
  const double from_line = std::hypot(beyond, point.z());
  const Vec3 radial(point.x() / rho, point.y() / rho, 0.0);
  const Vec3 round_axis(-radial.y(), radial.x(), 0.0);

  const double m = torus.round_axis, n = torus.round_tube;
  const double at_axis = m * std::atan2(point.y(), point.x());
  const double at_tube = n * std::atan2(point.z(), beyond);
  const Vec3 grad_phi = round_axis / rho;
  const Vec3 grad_theta = (beyond * Vec3::UnitZ() - point.z() * radial) / (from_line * from_line);
  const Vec3 grad_from_line = (beyond * radial + point.z() * Vec3::UnitZ()) / from_line;

  return {
      from_line - torus.tube - torus.amplitude * std::cos(at_axis) * std::cos(at_tube),
      grad_from_line + torus.amplitude * (m * std::sin(at_axis) * std::cos(at_tube) * grad_phi +
                                          n * std::cos(at_axis) * std::sin(at_tube) * grad_theta)};
}

SurfaceDistance torus_distance(const BumpyTorus& torus, const Vec3& point) {
  const ImplicitValue f = bumpy_torus(torus, point);
  const double steepness = f.gradient.norm();
  return {f.value / steepness, f.gradient / steepness};
}

Command penalty(const SurfaceDistance& surface, double stiffness) {
  Command command;
  command.elastic = stiffness * std::max(0.0, -surface.distance) * surface.normal;
  return command;
}

Environment environment(const Object& object) {
  return [object, memory = ContactMemory{}](const Tool& tool) mutable {
    return touch(object, tool, memory);
  };
}

}  // namespace feltwire
