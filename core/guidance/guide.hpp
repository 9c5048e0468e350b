#pragma once
// Virtual fixtures (Rosenberg 1993): forces that guide a hand where there is nothing to touch.

#include <array>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/shapes.hpp"

namespace feltwire {

// The places that a guide can have, in its own frame.

/// No place: it acts wherever the tool is.
struct Everywhere {};
/// The origin.
struct GuidePoint {};
/// Along z, centred.
struct GuideLine {
  double half_length = std::numeric_limits<double>::infinity();  // [m], > 0
};
/// Straight from point to point.
struct GuideCurve {
  std::vector<Vec3> points;  // [m], two or more
  bool closed = false;       // the last is joined to the first
};
/// z = 0; where an inside is asked for, z < 0.
struct GuidePlane {};
using GuidePlace = std::variant<Everywhere, GuidePoint, GuideLine, GuideCurve, GuidePlane, Sphere,
                                Box, Capsule, Cylinder>;

// The forces of a guide; d [m] is the distance to the place, 0 inside a solid.

/// A spring towards the place: stiffness * d, less from half of `range` on, nothing beyond it.
struct Attract {
  double stiffness = 0.0;                                  // [N/m], > 0
  double damping = 0.0;                                    // [N s/m], >= 0, along the pull
  double range = std::numeric_limits<double>::infinity();  // [m], > 0
};
/// A spring away from the place, and from within a solid: stiffness * (margin - d), d < 0 inside,
/// never pulling. A tool right on a point, a line or a curve is in no direction from it and is not
/// pushed.
struct KeepOut {
  double stiffness = 0.0;  // [N/m], > 0
  double damping = 0.0;    // [N s/m], >= 0, along the push
  double margin = 0.0;     // [m], >= 0; > 0 for what has no inside
};
/// Towards the place, strongest at `reach`: max_force * 2 x / (1 + x^2), x = d / reach.
struct Magnet {
  double reach = 0.0;  // [m], > 0
};
/// Against every movement inside the place.
struct Viscosity {
  double damping = 0.0;  // [N s/m], > 0
};
/// The same force wherever the tool is inside the place: gravity, or what makes up for it.
struct ConstantForce {
  Vec3 force = Vec3::Zero();  // [N, world frame]
};
using GuideAction = std::variant<Attract, KeepOut, Magnet, Viscosity, ConstantForce>;

struct Guide {
  std::string name;
  GuidePlace place;
  Pose pose;  // of the place
  GuideAction action;
  double max_force = 0.0;  // [N], > 0: never more than this, damping included
};

/// The force on the hand (world frame). What depends on the position alone is elastic, and the
/// gradient of a potential but for a ConstantForce with a border; damping and viscosity are
/// frictional, and are what is cut off above max_force.
/// A tool that is not finite is given nothing. Never allocates.
Command guide_force(const Guide& guide, const Tool& tool) noexcept;

/// [m] nearer than this to `position` [m, world frame] it does nothing; 0 where it acts.
double begins(const Guide& guide, const Vec3& position) noexcept;

/// Whether it asks how fast the tool is.
bool needs_velocity(const Guide& guide) noexcept;
/// [N/m] the steepest its force gets with the position, but at a border; 0 where it does not
/// change.
double stiffness(const Guide& guide) noexcept;

/// The tool's place against a guide's.
struct ClosestPoint {
  Vec3 away = Vec3::Zero();  // unit, from the nearest point of the place to the tool, or out of the
                             // solid; zero where it has no direction
  double distance = 0.0;     // [m] < 0 inside a solid, or below the plane
};
/// Precondition: the place is not Everywhere. `position` [m, the place's frame].
ClosestPoint closest_point(const GuidePlace& place, const Vec3& position) noexcept;

}  // namespace feltwire
