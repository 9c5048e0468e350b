#pragma once

namespace feltwire {

/// The material of a surface. Per contact: F_n = stiffness * depth along the outward normal n.
struct Material {
  double stiffness = 1000.0;      // [N/m], > 0; also of the tangential stick spring
  double damping = 0.0;           // [N s/m], >= 0, along n; never makes a contact pull
  double static_friction = 0.0;   // mu_s, >= dynamic_friction
  double dynamic_friction = 0.0;  // mu_d, >= 0
  double viscous_friction = 0.0;  // [N s/m], >= 0, against the tangential velocity

  /// True if the surface is a spring only: no friction, no damping.
  bool is_spring() const { return !(static_friction + viscous_friction + damping > 0.0); }
};

}  // namespace feltwire
