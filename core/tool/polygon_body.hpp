#pragma once
// A tool of polygons: two closed meshes against each other, as convex parts.

#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/point_shell/object_motion.hpp"
#include "core/polyhedra/solid_parts.hpp"
#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// The convex parts of a tool, and of all that it touches.
struct PolygonBody {
  std::vector<Polyhedron> parts;   // [m, tool frame]
  std::vector<SolidParts> solids;  // one for each object of the scene, in their order
  double radius = 0.0;             // [m] of the farthest corner from the tool's origin
};

/// The parts of a tool, each given by its corners [m, tool frame]. Throws as polyhedron() does.
PolygonBody polygon_body(const std::vector<std::vector<Vec3>>& corners,
                         std::vector<SolidParts> solids);

/// The contact of the tool at a pose with the pairs that `near` holds: the law of
/// core/polyhedra/depth_integrals.hpp for each object, V summed over its pairs. Friction and
/// damping as add_contact(); damping is that of the material in proportion to the stiffness.
///
/// The clearance is a lower bound of the distance to all parts that are not touched, less what a
/// step may advance beyond it where a pair is not in `near`: so no pair is reached before it is
/// remembered. `push`, if given, becomes that of the pair which update_part_pairs() turns next.
/// Never allocates.
ShellContact polygon_contact(const PolygonBody& body, std::span<const Object> objects,
                             double contact_area, const PartPairs& near, const Pose& tool,
                             std::span<const ObjectMotion> motions = {},
                             PairPush* push = nullptr) noexcept;

/// [m] The clearance just after update_part_pairs(), at its pose.
double clearance(const PartPairs& near) noexcept;

/// Brings `near` up to date for the next step from this pose: call it once before each. A pair that
/// comes within kNearPairs is remembered with the direction between its parts. The energy at the
/// pose stays the same: a direction is changed only where the parts are apart before and after, or
/// where V stays the same to kSameDepth. `solids_moved`: since the last call. Never allocates.
void update_part_pairs(const PolygonBody& body, std::span<const Object> objects, const Pose& tool,
                       bool solids_moved, PartPairs& near) noexcept;

inline constexpr double kNearPairs = 6e-3;  // [m] remembered within this distance
inline constexpr double kStayAway = 1e-3;   // [m] from what is not remembered, in a step
inline constexpr double kLookAgain = 2e-3;  // [m] and at the latest when one may be this near
inline constexpr double kSameDepth = 1e-9;  // of V

}  // namespace feltwire
