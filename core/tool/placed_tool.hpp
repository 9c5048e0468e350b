#pragma once
// A tool of polygons in an object's frame.

#include "core/polyhedra/convex_gap.hpp"
#include "core/polyhedra/depth_integrals.hpp"
#include "core/tool/polygon_body.hpp"

namespace feltwire {

/// [m] No point within `radius` of the tool's origin has moved farther.
inline double travel(const Pose& from, const Pose& to, double radius) {
  return (to.position - from.position).norm() +
         radius * rotation_between(from.orientation, to.orientation).norm();
}

struct PlacedTool {
  Mat3 rotation;
  Vec3 origin;  // [m]

  PlacedTool(const Pose& tool, const Pose& object)
      : rotation((object.orientation.conjugate() * tool.orientation).toRotationMatrix()),
        origin(object.orientation.conjugate() * (tool.position - object.position)) {}

  /// [m] How far a part lies at least along a direction.
  double least(const Polyhedron& part, const Vec3& direction) const noexcept {
    return direction.dot(origin) + least_along(part, rotation.transpose() * direction);
  }

  /// [m] A lower bound of the distance of a pair: along its direction, or for planes and hollows
  /// along their faces. Zero where there is no direction.
  double gap(const PolygonBody& body, const SolidParts& solid,
             const PartPair& pair) const noexcept {
    const Polyhedron& part = body.parts[pair.tool_part];
    if (is_simple(solid)) return gap_of_simple(part, solid);
    return pair.thickened ? least(part, pair.away) - pair.reach : 0.0;
  }

  /// A plane or a hollow: it needs no direction, as behind its faces all is solid.
  static bool is_simple(const SolidParts& solid) {
    return solid.hollow || solid.parts[0].shape.vertices.empty();
  }
  double gap_of_simple(const Polyhedron& part, const SolidParts& solid) const noexcept {
    double gap = std::numeric_limits<double>::infinity();
    for (const HalfSpaceBelow& plane : solid.parts[0].shape.planes)
      gap = std::min(gap, solid.hollow ? plane.offset + least(part, -plane.normal)
                                       : least(part, plane.normal) - plane.offset);
    return gap;
  }

  /// Whether a point [m] is in a part and in one of the solid.
  bool hold(const Polyhedron& part, const Polyhedron& solid, const Vec3& point) const noexcept {
    const Vec3 own = rotation.transpose() * (point - origin);
    const auto below = [](const Polyhedron& shape, const Vec3& p) {
      for (const HalfSpaceBelow& plane : shape.planes)
        if (plane.normal.dot(p) > plane.offset) return false;
      return true;
    };
    return below(solid, point) && below(part, own);
  }

  void add(const PolygonBody& body, const SolidParts& solid, const PartPair& pair, bool slides,
           DepthSums& sums) const noexcept {
    add_depth({body.parts[pair.tool_part], rotation, origin}, solid.parts[pair.solid_part],
              solid.hollow, pair.thickened ? &pair.away : nullptr, slides, sums);
  }
};

}  // namespace feltwire
