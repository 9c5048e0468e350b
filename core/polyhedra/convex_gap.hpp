#pragma once
// The distance of two convex polyhedra, and the plane between them.

#include <optional>

#include "core/polyhedra/polyhedron.hpp"

namespace feltwire {

struct ConvexGap {
  Vec3 away = Vec3::UnitZ();  // unit, from b to a: normal of a plane between them
  /// [m] Extent of `away` between the two: never more than their distance, and the distance to
  /// rounding where the search ends before kGapRounds. Zero or less: no plane was found.
  double distance = 0.0;
  /// [m] A point of both, b's frame, where the search found one: then they overlap.
  std::optional<Vec3> shared = {};
};

inline constexpr int kGapRounds = 32;

/// The gap between polyhedron a, placed at rotation * p + position, and b, in b's frame. `guess`: a
/// direction from b to a, of any length; the direction of the query before saves rounds. The search
/// is that of Gilbert, Johnson & Keerthi 1988 for the least point of the difference of the two.
/// The extents along `away` prove the result, whatever rounding does to the search.
/// Never allocates.
ConvexGap convex_gap(const Polyhedron& a, const Mat3& rotation, const Vec3& position,
                     const Polyhedron& b, const Vec3& guess) noexcept;

/// [m] The least of direction . v over the vertices, +infinity without any.
double least_along(const Polyhedron& solid, const Vec3& direction) noexcept;

}  // namespace feltwire
