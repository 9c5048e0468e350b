#pragma once
// One tool point against one object: penalty force from the proxy, friction from a stick point.

#include <string>

#include "core/contact/material.hpp"
#include "core/contact/shapes.hpp"
#include "core/types.hpp"

namespace feltwire {

struct Object {
  std::string name;
  Shape shape;
  Side felt_from = Side::outside;
  Pose pose;
  Material material;
};

/// What one tool remembers of one object between samples.
struct ContactMemory {
  FeatureMemory feature;
  bool touching = false;
  bool slipping = false;
  Vec3 anchor = Vec3::Zero();  // [m, object frame] the stick point: on the surface, or
                               // while it is dragged in the proxy's tangent plane
};

/// The force on the hand (world frame) that the object answers the tool with; zero and a cleared
/// memory when free.
///   elastic     stiffness * depth * n
///   frictional  stick spring stiffness * (anchor - proxy) along the surface, kept inside the cone
///   |F_t| <= mu |F_n|:
///               mu_s until it breaks, then mu_d with the anchor dragged along, until the spring
///               needs less than mu_d (Salisbury et al. 1995; Harwin & Melder 2002), plus
///               -viscous_friction * v_t, plus -damping * v_n, limited so that elastic + damping
///               never pulls.
Command touch(const Object& object, const Tool& tool, ContactMemory& memory) noexcept;

}  // namespace feltwire
