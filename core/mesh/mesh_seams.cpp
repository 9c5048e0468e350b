#include "core/mesh/mesh_seams.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "core/base/splitmix.hpp"
#include "core/geometry/segment.hpp"

namespace feltwire::mesh_seams {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Least length of a side, as a share of the triangle's longest side. A shorter side is a rounding
/// error, for example at a pole with the computed radius sin(pi).
constexpr double kNoSide = 0x1p-40;
constexpr double kPartOfSide = 0.25;

struct End {
  std::uint32_t vertex;
  double reach;  // [m] largest movement of the vertex
};

/// Returns the vertices at the ends of open edges, sorted by ascending reach.
std::vector<End> ends_of(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                         std::span<const Edge> open, double weld) {
  std::vector<double> reach(vertices.size(), -1.0);
  for (const Edge& edge : open)
    for (const std::uint32_t v : edge) reach[v] = weld;
  for (const Triangle& t : triangles) {
    if (reach[t[0]] < 0.0 && reach[t[1]] < 0.0 && reach[t[2]] < 0.0) continue;
    std::array<double, 3> side{};
    for (std::size_t k = 0; k < 3; ++k)
      side[k] = (vertices[t[corner_after(k)]] - vertices[t[k]]).norm();
    const double longest = std::max({side[0], side[1], side[2]});
    for (std::size_t k = 0; k < 3; ++k)
      if (side[k] > kNoSide * longest)
        for (const std::uint32_t v : {t[k], t[corner_after(k)]})
          reach[v] = std::min(reach[v], kPartOfSide * side[k]);
  }
  std::vector<End> ends;
  for (std::uint32_t v = 0; v < reach.size(); ++v)
    if (reach[v] > 0.0) ends.push_back({v, reach[v]});
  std::ranges::sort(ends, [](const End& a, const End& b) {
    return a.reach < b.reach || (a.reach == b.reach && a.vertex < b.vertex);
  });
  return ends;
}

/// A hash grid of the vertices that are not merged into others. The size of a cell is the reach of
/// its vertices, rounded up to a power of two. The vertices of a cell are at least half a cell
/// apart, so a cell holds few vertices.
class RemainingVertices {
 public:
  explicit RemainingVertices(std::span<const Vec3> vertices) : vertices_(vertices) {}

  void add(const End& end) {
    const int level = std::ilogb(end.reach) + 1;
    // The ends come in ascending order of reach, so the levels ascend too.
    if (levels_.empty() || levels_.back() != level) levels_.push_back(level);
    cells_[cell_hash(level, cell_of(level, vertices_[end.vertex]))].push_back(end);
  }

  /// Returns the nearest vertex that is within its own reach and within that of end.vertex. Returns
  /// end.vertex if there is none. `distance` is in [m].
  std::uint32_t nearest(const End& end, double& distance) const {
    std::uint32_t best = end.vertex;
    distance = kInfinity;
    const Vec3& p = vertices_[end.vertex];
    for (const int level : levels_) {
      const Vec3 middle = cell_of(level, p);
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = -1; z <= 1; ++z) {
            const auto at = cells_.find(cell_hash(level, middle + Vec3(x, y, z)));
            if (at == cells_.end()) continue;
            for (const End& other : at->second) {
              const double apart = (vertices_[other.vertex] - p).norm();
              if (!(apart <= std::min(end.reach, other.reach))) continue;
              if (apart > distance || (apart == distance && other.vertex > best)) continue;
              best = other.vertex;
              distance = apart;
            }
          }
    }
    return best;
  }

 private:
  static Vec3 cell_of(int level, const Vec3& p) {
    const double size = std::ldexp(1.0, level);
    return {std::floor(p.x() / size), std::floor(p.y() / size), std::floor(p.z() / size)};
  }
  static std::uint64_t cell_hash(int level, const Vec3& cell) {
    auto hash = static_cast<std::uint64_t>(level);
    for (const double x : cell) hash = splitmix::mix(hash ^ std::bit_cast<std::uint64_t>(x + 0.0));
    return hash;
  }

  std::span<const Vec3> vertices_;
  std::vector<int> levels_;
  std::unordered_map<std::uint64_t, std::vector<End>> cells_;
};

/// A closed ring or a chain of open edges (edges with one triangle), as its vertices in order. The
/// first vertex is not repeated.
struct Ring {
  std::vector<std::uint32_t> vertices;
  bool closed = false;
};

std::vector<Ring> rings_of(std::size_t vertices, std::span<const Edge> open) {
  std::vector<std::uint32_t> first(vertices + 1, 0);
  for (const Edge& edge : open)
    for (const std::uint32_t v : edge) ++first[v + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<std::uint32_t> at(2 * open.size()), next(first.begin(), first.end() - 1);
  for (std::uint32_t e = 0; e < open.size(); ++e)
    for (const std::uint32_t v : open[e]) at[next[v]++] = e;
  std::copy(first.begin(), first.end() - 1, next.begin());

  std::vector<bool> used(open.size());
  std::vector<Ring> rings;
  for (std::uint32_t start = 0; start < open.size(); ++start) {
    if (used[start]) continue;
    used[start] = true;
    Ring ring{{open[start][0], open[start][1]}, false};
    for (bool found = true; found && !ring.closed;) {
      found = false;
      const std::uint32_t v = ring.vertices.back();
      for (; next[v] < first[v + 1] && !found; ++next[v]) {
        const std::uint32_t e = at[next[v]];
        if (used[e]) continue;
        used[e] = found = true;
        const std::uint32_t other = open[e][0] == v ? open[e][1] : open[e][0];
        ring.closed = other == ring.vertices.front();
        if (!ring.closed) ring.vertices.push_back(other);
      }
    }
    ring.closed = ring.closed || ring.vertices.size() > 2;  // A straight side closes the chain.
    rings.push_back(std::move(ring));
  }
  return rings;
}

/// Points along a ring, and the arc length [m] to each point.
struct Rim {
  std::vector<Vec3> places;
  std::vector<double> along;  // A closed rim has places.size() + 1 numbers.
  double whole = 0.0;         // [m] length of the rim
  bool closed = false;
};

/// Divides the ring into sides of at most 1 / `parts` of its length, and returns its points.
Rim rim_of(std::span<const Vec3> vertices, const Ring& ring, double parts) {
  Rim rim{.places = {}, .along = {0.0}, .whole = 0.0, .closed = ring.closed};
  const std::size_t count = ring.vertices.size(), sides = ring.closed ? count : count - 1;
  const auto place = [&](std::size_t i) -> const Vec3& {
    return vertices[ring.vertices[i % count]];
  };
  for (std::size_t i = 0; i < sides; ++i) rim.whole += (place(i + 1) - place(i)).norm();
  for (std::size_t i = 0; i < sides; ++i) {
    const Vec3 side = place(i + 1) - place(i);
    const double length = side.norm();
    const int pieces = static_cast<int>(std::max(1.0, std::ceil(length / rim.whole * parts)));
    for (int n = 0; n < pieces; ++n) {
      rim.places.push_back(place(i) + static_cast<double>(n) / pieces * side);
      rim.along.push_back(rim.along.back() + length / pieces);
    }
  }
  if (!ring.closed) rim.places.push_back(place(sides));
  return rim;
}

/// Returns the distance [m] from the rim's point `p` to the opposite side. The arc length of `p` is
/// `at` [m].
double across(const Rim& rim, const Vec3& p, double at) {
  // A side is opposite if the arc length to it is at least kAlong times the straight distance. This
  // ratio is pi / 2 between opposite points of a circle, and at most sqrt(2) at a right corner.
  constexpr double kAlong = 1.49;
  double least = kInfinity;
  for (std::size_t k = 0; k + 1 < rim.along.size(); ++k) {
    const Vec3 &a = rim.places[k], &b = rim.places[(k + 1) % rim.places.size()];
    const auto [share, nearest] = nearest_on_segment(a, b, p);
    const double apart = (nearest - p).norm();
    double way = std::abs(rim.along[k] + share * (rim.along[k + 1] - rim.along[k]) - at);
    if (rim.closed) way = std::min(way, rim.whole - way);
    if (way > 0.0 && way >= kAlong * apart) least = std::min(least, apart);
  }
  return least;
}

/// Returns the width [m] of a ring: the upper quartile of the distances from the rim to the
/// opposite side.
double width(std::span<const Vec3> vertices, const Ring& ring) {
  constexpr std::size_t kLeast = 16, kMost = 64, kOfSide = 4;
  const std::size_t samples = std::clamp(kOfSide * ring.vertices.size(), kLeast, kMost);
  const Rim rim = rim_of(vertices, ring, static_cast<double>(samples));
  if (!(rim.whole > 0.0)) return 0.0;
  std::vector<double> widths;
  std::size_t k = 0;
  for (std::size_t n = 0; n < samples; ++n) {
    const double at = (static_cast<double>(n) + 0.5) / static_cast<double>(samples) * rim.whole;
    while (k + 2 < rim.along.size() && rim.along[k + 1] < at) ++k;
    const double side = rim.along[k + 1] - rim.along[k];
    const double part = side > 0.0 ? std::clamp((at - rim.along[k]) / side, 0.0, 1.0) : 0.0;
    const Vec3& a = rim.places[k];
    const Vec3& b = rim.places[(k + 1) % rim.places.size()];
    const double found = across(rim, a + part * (b - a), at);
    if (std::isfinite(found)) widths.push_back(found);
  }
  if (widths.empty()) return 0.5 * rim.whole;  // The ring has no opposite side.
  const auto most = widths.begin() + static_cast<std::ptrdiff_t>(3 * (widths.size() - 1) / 4);
  std::nth_element(widths.begin(), most, widths.end());
  return *most;
}

}  // namespace

Joined join(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
            std::span<const Edge> open, double weld) {
  Joined joined;
  joined.renamed.resize(vertices.size());
  for (std::uint32_t v = 0; v < vertices.size(); ++v) joined.renamed[v] = v;
  if (!(weld > 0.0)) return joined;
  RemainingVertices standing(vertices);
  for (const End& end : ends_of(vertices, triangles, open, weld)) {
    double distance = 0.0;
    const std::uint32_t other = standing.nearest(end, distance);
    if (other == end.vertex) {
      standing.add(end);
      continue;
    }
    joined.renamed[end.vertex] = other;
    ++joined.count;
    joined.farthest = std::max(joined.farthest, distance);
  }
  return joined;
}

MeshHoles holes(std::span<const Vec3> vertices, std::span<const Edge> open) {
  MeshHoles found;
  for (const Ring& ring : rings_of(vertices.size(), open)) {
    const double here = width(vertices, ring);
    found.narrowest = found.count == 0 ? here : std::min(found.narrowest, here);
    found.widest = std::max(found.widest, here);
    ++found.count;
  }
  return found;
}

}  // namespace feltwire::mesh_seams
