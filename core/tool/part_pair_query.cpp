// Chooses the pairs of convex parts that a tool of polygons stores.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/tool/placed_tool.hpp"
#include "core/tool/polygon_body.hpp"

namespace feltwire {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

auto key(const PartPair& pair) { return std::tuple(pair.object, pair.tool_part, pair.solid_part); }
bool in_order(const PartPair& a, const PartPair& b) { return key(a) < key(b); }

/// Returns the distance [m] from a ball to an axis-aligned box, or -`radius` if the ball's centre
/// is inside.
double distance_of(const Vec3& centre, double radius, const Polyhedron& box) {
  const Vec3 out = (box.least - centre).cwiseMax(centre - box.most).cwiseMax(Vec3::Zero());
  return out.norm() - radius;
}

/// Visits all pairs of a tool's part and a solid's part once.
struct PartPairQuery {
  const PolygonBody& body;
  std::span<const Object> objects;
  const PartPairs& before;
  PartPairs& now;

  const PartPair* known(const PartPair& pair) const {
    const auto end = before.pairs.begin() + static_cast<std::ptrdiff_t>(before.count);
    const auto at = std::lower_bound(before.pairs.begin(), end, pair, in_order);
    return at != end && key(*at) == key(pair) ? &*at : nullptr;
  }

  /// Stores a pair. If there are too many pairs, keeps the nearest pairs. Touching pairs have
  /// priority.
  void keep(const PartPair& pair) {
    if (now.count < PartPairs::kMost) {
      now.pairs[now.count++] = pair;
      return;
    }
    auto farthest = std::ranges::max_element(now.pairs, {}, &PartPair::gap);
    if (farthest->gap <= pair.gap) {
      now.free = std::min(now.free, pair.gap);
      return;
    }
    now.free = std::min(now.free, farthest->gap);
    *farthest = pair;
  }

  void query_solid(std::size_t index, const PlacedTool& placed) {
    const SolidParts& solid = body.solids[index];
    const bool simple = PlacedTool::is_simple(solid);
    for (std::uint32_t t = 0; t < body.parts.size(); ++t) {
      const Polyhedron& part = body.parts[t];
      const Vec3 centre = placed.rotation * part.centre + placed.origin;
      if (!simple) {
        const double to_ball = (centre - solid.centre).norm() - part.radius - solid.radius;
        if (to_ball > kNearPairs && before_has_none(index, t)) {
          now.free = std::min(now.free, to_ball);
          continue;
        }
      }
      for (std::uint32_t s = 0; s < solid.parts.size(); ++s) {
        PartPair pair{.object = static_cast<std::uint32_t>(index), .tool_part = t, .solid_part = s};
        if (simple) {
          pair.gap = placed.gap_of_simple(part, solid);
        } else {
          const Polyhedron& shape = solid.parts[s].shape;
          const PartPair* const old = known(pair);
          const double to_box = distance_of(centre, part.radius, shape);
          if (old != nullptr)
            pair = *old;
          else if (to_box > kNearPairs)
            pair.gap = to_box;
          if (old != nullptr || !(pair.gap > kNearPairs)) turn_away(placed, solid, pair, centre);
        }
        if (pair.gap > kNearPairs)
          now.free = std::min(now.free, pair.gap);
        else
          keep(pair);
      }
    }
  }

  bool before_has_none(std::size_t index, std::uint32_t t) const {
    const PartPair from{.object = static_cast<std::uint32_t>(index), .tool_part = t};
    const auto end = before.pairs.begin() + static_cast<std::ptrdiff_t>(before.count);
    const auto at = std::lower_bound(before.pairs.begin(), end, from, in_order);
    return at == end || at->object != index || at->tool_part != t;
  }

  /// Sets the gap [m] of a pair. If the parts are separated, also sets the pair's direction to that
  /// of the line between their nearest points.
  void turn_away(const PlacedTool& placed, const SolidParts& solid, PartPair& pair,
                 const Vec3& centre) const {
    const Polyhedron &part = body.parts[pair.tool_part],
                     &shape = solid.parts[pair.solid_part].shape;
    const double known_gap = placed.gap(body, solid, pair);
    if (known_gap > kLookAgain) {
      pair.gap = known_gap;
      return;
    }
    if (pair.overlaps && placed.hold(part, shape, pair.shared)) {
      pair.gap = 0.0;
      return;
    }
    const Vec3 guess = pair.thickened ? pair.away : Vec3(centre - shape.centre);
    const ConvexGap found = convex_gap(part, placed.rotation, placed.origin, shape, guess);
    pair.gap = std::max(0.0, found.distance);
    pair.overlaps = found.shared.has_value();
    if (pair.overlaps) pair.shared = *found.shared;
    if (!(found.distance > 0.0)) return;
    if (pair.thickened && !(known_gap > 0.0)) {
      // The two parts are separated. However, the tool's part may still overlap the solid that is
      // thickened along the pair's direction.
      DepthSums sums;
      placed.add(body, solid, pair, false, sums);
      if (sums.cells > 0) {
        pair.gap = 0.0;
        return;
      }
    }
    pair.thickened = true;
    pair.away = found.away;
    pair.reach = -least_along(shape, -found.away);
  }

  void all(const Pose& tool) {
    now.count = 0;
    now.free = kInfinity;
    now.from = tool;
    now.known = true;
    for (std::size_t i = 0; i < objects.size(); ++i)
      query_solid(i, PlacedTool(tool, objects[i].pose));
    std::sort(now.pairs.begin(), now.pairs.begin() + static_cast<std::ptrdiff_t>(now.count),
              in_order);
  }
};

/// Returns the push (contact integrals) of a pair. Reuses the last push if the pair and the pose
/// are the same.
PairPush push_of(const PolygonBody& body, const SolidParts& solid, const PlacedTool& placed,
                 const Pose& tool, const PartPair& pair, const PairPush& last) {
  constexpr double kRounding = 1e-15;  // rounding error of a repeated normalization
  const PartPair& same = last.pair;
  const auto turned = last.tool.orientation.coeffs() - tool.orientation.coeffs();
  if (last.known && key(same) == key(pair) && same.thickened == pair.thickened &&
      same.away == pair.away && last.tool.position == tool.position &&
      turned.cwiseAbs().maxCoeff() < kRounding)
    return last;
  DepthSums sums;
  placed.add(body, solid, pair, false, sums);
  return {true, pair, tool, sums.cubes, sums.slope.head<3>()};
}

/// Aligns the direction of a touching pair with its force, if the depth of the contact stays almost
/// equal.
void follow(const PolygonBody& body, const SolidParts& solid, const PlacedTool& placed,
            const Pose& tool, const PairPush& last, PartPair& pair) {
  constexpr double kAligned = 0.9998;  // cosine of one degree
  if (PlacedTool::is_simple(solid) || placed.gap(body, solid, pair) > 0.0) return;
  const PairPush old = push_of(body, solid, placed, tool, pair, last);
  const double length = old.slope.norm();
  if (!(old.cubes > 0.0 && length > 0.0)) return;
  PartPair other = pair;
  other.away = old.slope / -length;
  if (pair.thickened && other.away.dot(pair.away) > kAligned) return;
  other.thickened = true;
  other.reach = -least_along(solid.parts[pair.solid_part].shape, -other.away);
  DepthSums sums;
  placed.add(body, solid, other, false, sums);
  if (sums.cubes <= old.cubes && sums.cubes >= (1.0 - kSameDepth) * old.cubes) pair = other;
}

}  // namespace

double clearance(const PartPairs& near) noexcept {
  double least = near.free - kToolAdvance - kStayAway;
  for (std::size_t i = 0; i < near.count; ++i)
    if (near.pairs[i].gap > 0.0) least = std::min(least, near.pairs[i].gap);
  return least;
}

void update_part_pairs(const PolygonBody& body, std::span<const Object> objects, const Pose& tool,
                       bool solids_moved, PartPairs& near) noexcept {
  const double left = near.free - travel(near.from, tool, body.radius);
  if (!near.known || solids_moved || !(left > kLookAgain)) {
    const PartPairs before = near;
    PartPairQuery{body, objects, before, near}.all(tool);
  } else {
    near.free = left;
    near.from = tool;
    const PartPairQuery query{body, objects, near, near};
    for (std::size_t i = 0; i < near.count; ++i) {
      PartPair& pair = near.pairs[i];
      const SolidParts& solid = body.solids[pair.object];
      const PlacedTool placed(tool, objects[pair.object].pose);
      if (PlacedTool::is_simple(solid)) {
        pair.gap = placed.gap(body, solid, pair);
        continue;
      }
      query.turn_away(placed, solid, pair,
                      placed.rotation * body.parts[pair.tool_part].centre + placed.origin);
    }
  }
  if (near.count == 0) return;
  near.turn = near.next_turn();
  if (solids_moved) near.push.known = false;
  PartPair& pair = near.pairs[near.turn];
  follow(body, body.solids[pair.object], PlacedTool(tool, objects[pair.object].pose), tool,
         near.push, pair);
}

}  // namespace feltwire
