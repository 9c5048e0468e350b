#pragma once
// Virtual fixtures (Rosenberg 1993): forces that guide a hand without a surface.

#include <array>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/shapes.hpp"

namespace feltwire {

// The places that a guide can have, in its own frame.

/// No place: the guide acts everywhere.
struct Everywhere {};
/// The origin of its frame.
struct GuidePoint {};
/// A line along z, centred.
struct GuideLine {
  double half_length = std::numeric_limits<double>::infinity();  // [m], > 0
};
/// Straight lines from point to point.
struct GuideCurve {
  std::vector<Vec3> points;  // [m], two or more
  bool closed = false;       // the last is joined to the first
};
/// A shape is a place too: a plane is z = 0 with the inside z < 0.
using GuidePlace = Primitives::After<Everywhere, GuidePoint, GuideLine, GuideCurve>::And<>;

// The forces of a guide; d [m] is the distance to the place, 0 inside a solid.

/// A spring towards the place: stiffness * d. It fades from half of `range` on and is zero beyond
/// it.
struct Attract {
  double stiffness = 0.0;                                  // [N/m], > 0
  double damping = 0.0;                                    // [N s/m], >= 0, along the pull
  double range = std::numeric_limits<double>::infinity();  // [m], > 0
};
/// A spring away from the place, also from inside a solid: stiffness * (margin - d), d < 0 inside.
/// It never pulls. A tool exactly on a point, a line or a curve is not pushed, because there is no
/// direction.
struct KeepOut {
  double stiffness = 0.0;  // [N/m], > 0
  double damping = 0.0;    // [N s/m], >= 0, along the push
  double margin = 0.0;     // [m], >= 0; > 0 for a place without an inside
};
/// A pull towards the place, strongest at `reach`: max_force * 2 x / (1 + x^2), x = d / reach.
struct Magnet {
  double reach = 0.0;  // [m], > 0
};
/// A force against every movement inside the place.
struct Viscosity {
  double damping = 0.0;  // [N s/m], > 0
};
/// A constant force inside the place: gravity, or a compensation of gravity.
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

/// The force on the hand (world frame). The part that depends only on the position is elastic. It
/// is the gradient of a potential, except for a ConstantForce with a border. Damping and viscosity
/// are frictional; they are cut first if the force exceeds max_force. A tool whose numbers are not
/// finite gets zero. Never allocates.
Command guide_force(const Guide& guide, const Tool& tool) noexcept;

/// [m] No tool within this distance of `position` [m, world frame] gets a force; 0 if the guide
/// acts there.
double begins(const Guide& guide, const Vec3& position) noexcept;

/// Whether the force depends on the tool's velocity.
bool needs_velocity(const Guide& guide) noexcept;
/// [N/m] the largest slope of the force over the position, borders excluded; 0 if the force is
/// constant.
double stiffness(const Guide& guide) noexcept;

/// The position of a tool relative to a guide's place.
struct ClosestPoint {
  Vec3 away = Vec3::Zero();  // unit, from the nearest point of the place to the tool, or out of the
                             // solid; zero where it has no direction
  double distance = 0.0;     // [m] < 0 inside a solid, or below the plane
};
/// Precondition: the place is not Everywhere. `position` [m, the place's frame].
ClosestPoint closest_point(const GuidePlace& place, const Vec3& position) noexcept;

}  // namespace feltwire
