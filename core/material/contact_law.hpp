#pragma once
// The law of contact: the force of a surface on a tool that is behind it. The objects of a scene
// and the patches of a local model share it.

#include <algorithm>

#include "core/base/types.hpp"
#include "core/geometry/shapes.hpp"
#include "core/material/material.hpp"

namespace feltwire {

/// The memory of one tool for one object, between samples.
struct ContactMemory {
  FeatureMemory feature;
  bool touching = false;
  bool slipping = false;
  Vec3 anchor = Vec3::Zero();  // [m, frame of the surface] the stick point: on the surface, or
                               // while it is dragged in the proxy's tangent plane
};

/// How far the stick spring is stretched along the surface [m, frame of the surface]; moves the
/// anchor and the stick / slip state on by one sample. The spring's force is stiffness times this,
/// kept inside the cone |F_t| <= mu |F_n|: mu_s until it breaks, then mu_d with the anchor dragged
/// along, until the spring needs less than mu_d (Salisbury et al. 1995; Harwin & Melder 2002).
/// Precondition: surface.depth > 0; memory.touching is still that of the sample before.
Vec3 stick_stretch(const Material& material, const SurfacePoint& surface,
                   ContactMemory& memory) noexcept;

/// A stick point that goes from facet to facet turns with the surface, so that its spring is as
/// long after an edge as before: without that a hand would get round corners by each facet's cosine
/// for nothing. `about` [m] the proxy of the sample before, `from` and `to` its normal and the new
/// one, unit.
Vec3 carried(const Vec3& anchor, const Vec3& about, const Vec3& from, const Vec3& to) noexcept;

/// The force on the hand, any one frame.
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
