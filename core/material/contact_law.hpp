#pragma once
// The law of contact: the force of a surface on a tool that has gone through it. Scenes and local
// models share it.

#include <algorithm>

#include "core/base/types.hpp"
#include "core/geometry/shapes.hpp"
#include "core/material/material.hpp"

namespace feltwire {

/// The state of one tool's contact with one object, kept between samples.
struct ContactMemory {
  FeatureMemory feature;
  bool touching = false;
  bool slipping = false;
  Vec3 anchor = Vec3::Zero();  // [m, frame of the surface] the stick point: on the surface, or
                               // while it is dragged in the proxy's tangent plane
};

/// Updates the anchor and the stick / slip state by one sample. Returns how far the stick spring is
/// stretched along the surface [m, frame of the surface]. The spring's force is stiffness times
/// this stretch and stays inside the cone |F_t| <= mu |F_n|. While the tool sticks, mu is mu_s.
/// When the force leaves that cone the tool slips: mu is mu_d and the anchor is dragged along,
/// until the spring needs less than mu_d (Salisbury et al. 1995; Harwin & Melder 2002).
/// Precondition: surface.depth > 0; memory.touching is still that of the previous sample.
Vec3 stick_stretch(const Material& material, const SurfacePoint& surface,
                   ContactMemory& memory) noexcept;

/// Turns the stick point with the surface when it goes from one facet to the next. The stretch of
/// the spring then stays the same. Without this each edge would shorten the spring by the cosine of
/// its angle, and the hand would slide round corners too easily. `about` [m]: the proxy of the
/// previous sample; `from` and `to`: its normal and the new one, unit.
Vec3 carried(const Vec3& anchor, const Vec3& about, const Vec3& from, const Vec3& to) noexcept;

/// The force on the hand. All vectors are in one frame.
///   elastic     stiffness * depth * normal
///   frictional  stick_force (of stick_stretch(); zero without static friction), plus
///               -viscous_friction * v_t, plus -damping * v_n, limited so that elastic + damping
///               never pulls.
/// `velocity` [m/s] of the tool against the surface.
inline Command contact_force(const Material& material, double depth, const Vec3& normal,
                             const Vec3& stick_force, const Vec3& velocity) noexcept {
  const double elastic = material.stiffness * depth;
  Command command;
  command.elastic = elastic * normal;
  command.frictional = stick_force;
  if (material.viscous_friction > 0.0 || material.damping > 0.0) {
    const double leaving = velocity.dot(normal);  // [m/s] out of the surface
    command.frictional -= material.viscous_friction * (velocity - leaving * normal);
    command.frictional += std::max(-elastic, -material.damping * leaving) * normal;
  }
  return command;
}

}  // namespace feltwire
