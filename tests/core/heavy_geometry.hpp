#pragma once
// Geometry that is expensive to touch: what a malicious server could send, and what a heavy scene
// contains.

#include <cmath>
#include <numbers>
#include <vector>

#include "core/local_model/prefetched_geometry.hpp"

namespace feltwire::test {

/// Direction `i` of `count` directions, spread evenly over a sphere.
inline Vec3 spread_direction(std::size_t i, std::size_t count) {
  constexpr double kGoldenAngle = 2.399963229728653;  // [rad]
  const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
  const double r = std::sqrt(1.0 - z * z), turn = kGoldenAngle * static_cast<double>(i);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

/// Long thin triangles in all directions. Each has an edge through the origin.
inline SurfaceData through_a_point(std::size_t count) {
  constexpr double kReach = 0.1, kThin = 1e-3;  // [m]
  SurfaceData data;
  data.double_sided = true;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 along = kReach * spread_direction(i, count);
    const Vec3 aside = kThin * along.cross(Vec3(0.3, 0.5, 0.8)).normalized();
    const auto first = static_cast<std::uint32_t>(data.vertices.size());
    for (const Vec3& corner : {Vec3(-along), along, Vec3(along + aside)})
      data.vertices.push_back(corner);
    data.triangles.push_back({first, first + 1, first + 2});
  }
  return data;
}

/// A cone about z whose triangles all meet at its apex, the origin. The solid is below.
inline SurfaceData round_a_corner(std::size_t count) {
  constexpr double kRadius = 0.1, kHeight = 0.02;  // [m]
  SurfaceData data;
  data.vertices.push_back(Vec3::Zero());
  for (std::size_t i = 0; i < count; ++i) {
    const double turn =
        2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    data.vertices.emplace_back(kRadius * std::cos(turn), kRadius * std::sin(turn), -kHeight);
  }
  for (std::size_t i = 0; i < count; ++i)
    data.triangles.push_back(
        {0, static_cast<std::uint32_t>(1 + i), static_cast<std::uint32_t>(1 + (i + 1) % count)});
  return data;
}

/// A tool whose points are spread over a ball of 40 mm.
inline BodyData ball_of_points(std::size_t count) {
  BodyData body;
  body.coupling = {1000.0, 1.0, 20.0, 1.0};
  body.area = body.contact_area = 5e-3;
  for (std::size_t i = 0; i < count; ++i) body.points.push_back(0.04 * spread_direction(i, count));
  return body;
}

/// Thin plates across z, each 10 um above the previous one, from the origin up: a tool that lies
/// on them is near them all.
inline std::vector<SolidData> thin_boxes(std::size_t count) {
  std::vector<SolidData> solids;
  for (std::size_t i = 0; i < count; ++i) {
    SolidData& solid = solids.emplace_back();
    solid.object = static_cast<std::uint16_t>(i);
    solid.shape = Box{.half_extents = Vec3(0.1, 0.1, 0.2e-3)};
    solid.pose.position.z() = 1e-5 * static_cast<double>(i);
    solid.material = {.stiffness = 1000.0, .static_friction = 0.5, .dynamic_friction = 0.4};
  }
  return solids;
}

}  // namespace feltwire::test
