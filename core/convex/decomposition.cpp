#include "core/convex/decomposition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/base/parallel.hpp"
#include "core/convex/clipped_solid.hpp"
#include "core/convex/outward_error.hpp"

namespace feltwire {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Number of pieces to cut per requested part. Joining the pieces later reduces their number.
constexpr std::size_t kPiecesPerPart = 2;
/// A part below this share of the whole volume is a rounding error.
constexpr double kDust = 1e-9;

struct Piece {
  ClippedSolid solid;
  ConvexHull hull;
  double outside = 0.0;  // [m] outward_error() of the hull
};

/// Cuts one mesh into pieces.
struct Cutter {
  const MeshSurface& surface;
  double tolerance;  // [m] largest outward_error() of a piece

  double outside(const ConvexHull& hull) const { return outward_error(hull, surface, tolerance); }

  /// Returns true if a piece is thinner along a direction than the tolerance. A cut across such a
  /// direction brings no hull nearer to the surface. Without this test, a thin plate with a hollow
  /// in its rim would be cut again and again.
  bool is_thin(const Piece& piece, const Vec3& direction) const {
    double least = kInfinity, most = -kInfinity;
    for (const Vec3& v : piece.hull.vertices) {
      least = std::min(least, direction.dot(v));
      most = std::max(most, direction.dot(v));
    }
    return most - least < tolerance;
  }

  /// Returns the plane whose two pieces have the least volume of hulls together. Among planes with
  /// equal volumes, prefers pieces of equal size, to avoid thin slices.
  std::optional<HalfSpaceBelow> best_cut(const Piece& piece) const {
    constexpr double kUneven = 0.02;
    const std::vector<HalfSpaceBelow> cuts = piece.solid.cuts();
    std::vector<double> cost(cuts.size(), kInfinity);
    parallel_for(cuts.size(), [&](std::size_t i) {
      if (is_thin(piece, cuts[i].normal)) return;
      const auto sides = piece.solid.points_beside(cuts[i]);
      const auto below = convex_hull(sides.first), above = convex_hull(sides.second);
      if (!below || !above) return;
      cost[i] = below->volume + above->volume + kUneven * std::abs(below->volume - above->volume);
    });
    const auto best = std::ranges::min_element(cost);
    if (best == cost.end() || *best == kInfinity) return std::nullopt;
    return cuts[static_cast<std::size_t>(best - cost.begin())];
  }

  std::optional<Piece> piece(ClippedSolid solid) const {
    auto hull = convex_hull(solid.points());
    if (!hull) return std::nullopt;
    const double out = outside(*hull);
    return Piece{std::move(solid), *std::move(hull), out};
  }

  /// Cuts the mesh until the outward error of every piece is within the tolerance, or until there
  /// are `most` pieces.
  std::vector<Piece> cut(std::size_t most) const {
    std::vector<Piece> done, open;
    if (auto whole = piece(ClippedSolid(surface))) open.push_back(*std::move(whole));
    while (!open.empty()) {
      const auto worst = std::ranges::max_element(open, {}, &Piece::outside);
      std::swap(*worst, open.back());
      Piece next = std::move(open.back());
      open.pop_back();
      const bool enough = next.outside <= tolerance || done.size() + open.size() + 1 >= most;
      const auto at = enough ? std::nullopt : best_cut(next);
      if (!at) {
        done.push_back(std::move(next));
        continue;
      }
      for (const HalfSpaceBelow& side : {*at, HalfSpaceBelow{-at->normal, -at->offset}})
        if (auto part = piece(next.solid.below(side))) open.push_back(*std::move(part));
    }
    return done;
  }
};

struct Part {
  ConvexHull hull;
  Bounds bounds;
};

Part part_of(ConvexHull hull) {
  Part part{std::move(hull), {}};
  for (const Vec3& v : part.hull.vertices) part.bounds.add(v);
  return part;
}

/// Two parts joined into one.
struct Join {
  std::size_t a = 0, b = 0;  // indices of the parts; a < b
  ConvexHull hull;
  double added = 0.0;  // [m^3] volume of the hull minus both volumes
  bool fits = true;    // false if the hull exceeds the tolerance
};

/// Joins pairs of parts, beginning with the pair that adds the least volume. A join may exceed the
/// tolerance only while there are more than `most` parts.
std::vector<Part> joined(const Cutter& cutter, std::vector<Part> parts, std::size_t most) {
  std::vector<Join> joins;
  const auto add_pairs = [&](const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
    std::vector<std::optional<ConvexHull>> hulls(pairs.size());
    parallel_for(pairs.size(), [&](std::size_t i) {
      std::vector<Vec3> points = parts[pairs[i].first].hull.vertices;
      const auto& more = parts[pairs[i].second].hull.vertices;
      points.insert(points.end(), more.begin(), more.end());
      hulls[i] = convex_hull(points);
    });
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (!hulls[i]) continue;
      const auto [a, b] = pairs[i];
      const double added = hulls[i]->volume - parts[a].hull.volume - parts[b].hull.volume;
      joins.push_back({a, b, *std::move(hulls[i]), added});
    }
  };
  const auto touch = [&](std::size_t a, std::size_t b) {
    return parts[a].bounds.grown(cutter.tolerance).overlaps(parts[b].bounds);
  };
  std::vector<std::uint8_t> is_left(parts.size(), 1);
  std::size_t left = parts.size();
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = a + 1; b < parts.size(); ++b)
      if (touch(a, b) || left > most) pairs.emplace_back(a, b);
  add_pairs(pairs);
  while (!joins.empty()) {
    check_cancelled();
    const auto better = [](const Join& x, const Join& y) {
      if (x.fits != y.fits) return x.fits;
      return std::tie(x.added, x.a, x.b) < std::tie(y.added, y.a, y.b);
    };
    const auto best = std::ranges::min_element(joins, better);
    if (best->fits && cutter.outside(best->hull) > cutter.tolerance) {
      best->fits = false;
      continue;
    }
    if (!best->fits && left <= most) break;
    const std::size_t a = best->a, b = best->b, made = parts.size();
    parts.push_back(part_of(std::move(best->hull)));
    is_left[a] = is_left[b] = 0;
    is_left.push_back(1);
    --left;
    std::erase_if(joins,
                  [&](const Join& j) { return j.a == a || j.a == b || j.b == a || j.b == b; });
    pairs.clear();
    for (std::size_t other = 0; other < made; ++other)
      if (is_left[other] != 0 && (touch(other, made) || left > most))
        pairs.emplace_back(other, made);
    add_pairs(pairs);
  }
  std::vector<Part> result;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (is_left[i] != 0) result.push_back(std::move(parts[i]));
  return result;
}

}  // namespace

double tolerance_of(const DecompositionOptions& options, const TriangleMesh& mesh) {
  return options.tolerance.value_or(kPartTolerance * mesh.report().size);
}

ConvexParts convex_parts(const MeshSurface& solid, const DecompositionOptions& options) {
  // outward_error() may find only this share of the true error.
  constexpr double kFound = 8.0 / 9.0;
  const double tolerance = tolerance_of(options, solid.mesh());
  const Cutter cutter{solid, kFound * tolerance};
  std::vector<Part> parts;
  for (Piece& piece : cutter.cut(options.most > 1 ? kPiecesPerPart * options.most : 1))
    if (piece.hull.volume > kDust * solid.mesh().report().volume)
      parts.push_back(part_of(std::move(piece.hull)));
  ConvexParts result{{}, tolerance, 0.0};
  for (Part& part : joined(cutter, std::move(parts), options.most)) {
    result.outside = std::max(result.outside, cutter.outside(part.hull));
    result.parts.push_back(std::move(part.hull.vertices));
  }
  return result;
}

}  // namespace feltwire
