#include "core/mesh/triangle_mesh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/base/splitmix.hpp"
#include "core/mesh/bucketed.hpp"
#include "core/mesh/doubled_faces.hpp"
#include "core/mesh/edge_splits.hpp"
#include "core/mesh/mesh_seams.hpp"

namespace feltwire {
namespace {

// With this limit, the index of a side fits 32 bits.
constexpr std::size_t kMostTriangles = std::size_t{1} << 30;
constexpr std::uint32_t kSides = 3;

/// Below this relative height, rounding errors dominate the triangle's normal. The corners are
/// exact. Their differences have an error of half a unit in the last place.
constexpr double kFlat = 8.0 * std::numeric_limits<double>::epsilon();

/// Returns true if the triangle has no area. If its height is then above `height` [m], sets
/// `height` to it.
bool degenerate(const std::array<Vec3, 3>& c, double& height) {
  const Vec3 a = c[1] - c[0], b = c[2] - c[0], o = c[2] - c[1];
  // [m] largest component of a side
  const double longest =
      std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), o.cwiseAbs().maxCoeff()});
  if (!(longest > 0.0)) return true;
  const double relative = (a / longest).cross(b / longest).norm();
  if (relative > kFlat) return false;
  height = std::max(height, relative * longest);
  return true;
}

std::uint64_t place_hash(const Vec3& v) {
  std::uint64_t h = 0;
  // The sum x + 0.0 is never -0.0.
  for (const double x : v) h = splitmix::mix(h ^ std::bit_cast<std::uint64_t>(x + 0.0));
  return h;
}

/// A hash table of the vertices, with open addressing.
class Places {
 public:
  explicit Places(std::size_t most) : slots_(std::bit_ceil(2 * most + 1), kEmpty) {}

  /// Returns the index of the vertex at exactly this position. Adds a new vertex with the index
  /// `next`.
  std::uint32_t find_or_add(const Vec3& v, const std::vector<Vec3>& known, std::uint32_t next) {
    std::size_t slot = place_hash(v) & (slots_.size() - 1);
    for (; slots_[slot] != kEmpty; slot = (slot + 1) & (slots_.size() - 1))
      if (known[slots_[slot]] == v) return slots_[slot];
    slots_[slot] = next;
    return next;
  }

 private:
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFF;
  std::vector<std::uint32_t> slots_;
};

void require_whole(const TriangleSoup& soup) {
  if (soup.triangles.size() > kMostTriangles || soup.vertices.size() > 3 * kMostTriangles)
    throw std::invalid_argument("mesh: triangles: must be at most 2^30, are " +
                                std::to_string(soup.triangles.size()) + "; simplify the surface");
  for (const Vec3& v : soup.vertices)
    if (!v.allFinite())
      throw std::invalid_argument(
          "mesh: vertices: must be finite, one is not; export the surface anew");
  for (const Triangle& t : soup.triangles)
    for (const std::uint32_t i : t)
      if (i >= soup.vertices.size())
        throw std::invalid_argument("mesh: triangles: index " + std::to_string(i) +
                                    " has no vertex, there are " +
                                    std::to_string(soup.vertices.size()) + "; correct the index");
}

}  // namespace

Vec3 triangle_normal(const std::array<Vec3, 3>& c) noexcept {
  // Use the two sides at the widest angle (opposite the longest side): they have the least
  // cancellation.
  const std::array<Vec3, 3> side = {c[1] - c[0], c[2] - c[1], c[0] - c[2]};
  const std::array<double, 3> square = {side[0].squaredNorm(), side[1].squaredNorm(),
                                        side[2].squaredNorm()};
  const std::size_t longest =
      static_cast<std::size_t>(std::max_element(square.begin(), square.end()) - square.begin());
  const Vec3& a = side[corner_after(longest)];
  const Vec3& b = side[corner_after(corner_after(longest))];
  const Vec3 normal = a.cross(b);
  const double squared = normal.squaredNorm();
  if (is_plain_square(squared)) [[likely]]
    return normal / std::sqrt(squared);
  return direction(Vec3(direction(a).cross(direction(b))));
}

TriangleMesh::TriangleMesh(const TriangleSoup& soup, std::optional<double> weld, bool solid)
    : solid_(solid) {
  require_whole(soup);
  this->weld(soup);
  if (triangles_.empty())
    throw std::invalid_argument("mesh: triangles: none with an area is left of " +
                                std::to_string(soup.triangles.size()) + "; give a surface");
  report_.size = 2.0 * half_extents_.maxCoeff();
  report_.weld = weld.value_or(kWeld * report_.size);
  report_.typical_side = typical_side();
  index_vertices();
  drop_duplicates();
  const auto open = split_open_edges(join_open_edges(find_neighbours())).edges;
  report_.holes = mesh_seams::holes(vertices_, open);
  for (std::size_t v = 0; v + 1 < first_.size(); ++v)
    report_.most_at_corner =
        std::max<std::size_t>(report_.most_at_corner, first_[v + 1] - first_[v]);
  report_.volume = volume();
}

/// Joins vertices at open edges. Returns the edges that are still open. A triangle that loses its
/// area can open further edges. The next round joins these edges.
TriangleMesh::OpenEdges TriangleMesh::join_open_edges(OpenEdges open) {
  constexpr int kMostJoinRounds = 8;
  for (int round = 0; round < kMostJoinRounds && !open.edges.empty(); ++round) {
    const mesh_seams::Joined joined =
        mesh_seams::join(vertices_, triangles_, open.edges, report_.weld);
    if (joined.count == 0) break;
    const std::vector<Triangle> before = triangles_;
    for (Triangle& t : triangles_)
      for (std::uint32_t& i : t) i = joined.renamed[i];
    if (!keep_areas()) {  // No triangle would remain.
      triangles_ = before;
      break;
    }
    report_.joined += joined.count;
    report_.joined_farthest = std::max(report_.joined_farthest, joined.farthest);
    index_vertices();
    drop_duplicates();
    open = find_neighbours();
  }
  return open;
}

/// Splits triangles at open edges, one side of a triangle per round. Returns the edges that are
/// still open.
TriangleMesh::OpenEdges TriangleMesh::split_open_edges(OpenEdges open) {
  constexpr int kMostSplitRounds = 32;
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
  const double weld = std::max(report_.weld, kRounding * report_.size);
  for (int round = 0; round < kMostSplitRounds && !open.edges.empty(); ++round) {
    edge_splits::Split split = edge_splits::split(vertices_, triangles_, open.sides, weld);
    report_.split.search_ended = report_.split.search_ended || !split.all_looked;
    if (split.edges == 0 || split.triangles.size() > kMostTriangles) break;
    report_.split.count += split.edges;
    report_.split.farthest = std::max(report_.split.farthest, split.farthest);
    report_.split.added += split.triangles.size() - triangles_.size();
    triangles_ = std::move(split.triangles);
    index_vertices();
    drop_duplicates();
    open = find_neighbours();
  }
  return open;
}

bool TriangleMesh::same_corners(std::uint32_t one, std::uint32_t other) const {
  for (const std::uint32_t v : triangles_[one])
    if (std::ranges::find(triangles_[other], v) == triangles_[other].end()) return false;
  return true;
}

std::uint32_t TriangleMesh::reverse_of(std::uint32_t t) const {
  if (report_.both_sides == 0) return kNone;
  for (const std::uint32_t other : around(triangles_[t][0]))
    if (other != t && same_corners(other, t)) return other;
  return kNone;
}

/// Drops triangles without an area and vertices without a triangle. Returns false if no triangle is
/// left.
bool TriangleMesh::keep_areas() {
  std::vector<Triangle> kept;
  double height = 0.0;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    if (!degenerate(corners(t), height)) kept.push_back(triangles_[t]);
  if (kept.empty()) return false;
  report_.degenerate_height = std::max(report_.degenerate_height, height);
  report_.degenerate += triangles_.size() - kept.size();
  triangles_ = std::move(kept);
  std::vector<std::uint32_t> place(vertices_.size(), kNone);
  for (const Triangle& t : triangles_)
    for (const std::uint32_t i : t) place[i] = 0;
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] == kNone) continue;
    place[i] = count;
    vertices_[count++] = vertices_[i];
  }
  vertices_.resize(count);
  for (Triangle& t : triangles_)
    for (std::uint32_t& i : t) i = place[i];
  return true;
}

double TriangleMesh::typical_side() const {
  std::vector<double> longest(triangles_.size());
  for (std::uint32_t t = 0; t < longest.size(); ++t) {
    const auto c = corners(t);
    longest[t] = std::max({(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()});
  }
  const auto middle = longest.begin() + static_cast<std::ptrdiff_t>(longest.size() / 2);
  std::nth_element(longest.begin(), middle, longest.end());
  return *middle;
}

void TriangleMesh::weld(const TriangleSoup& soup) {
  Places places(soup.vertices.size());
  std::vector<Vec3> known;
  known.reserve(soup.vertices.size());
  std::vector<std::uint32_t> renamed;
  renamed.reserve(soup.vertices.size());
  for (const Vec3& v : soup.vertices) {
    const auto next = static_cast<std::uint32_t>(known.size());
    renamed.push_back(places.find_or_add(v, known, next));
    if (renamed.back() == next) known.push_back(v);
  }

  std::vector<bool> used(known.size());
  triangles_.reserve(soup.triangles.size());
  for (const Triangle& t : soup.triangles) {
    const Triangle named = {renamed[t[0]], renamed[t[1]], renamed[t[2]]};
    if (degenerate({known[named[0]], known[named[1]], known[named[2]]},
                   report_.degenerate_height)) {
      ++report_.degenerate;
      continue;
    }
    for (const std::uint32_t i : named) used[i] = true;
    triangles_.push_back(named);
  }

  // Vertices without a triangle belong neither to the surface nor to its size.
  Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity()), most = -least;
  std::vector<std::uint32_t> place(known.size(), kNone);
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (!used[i]) continue;
    least = least.cwiseMin(known[i]);
    most = most.cwiseMax(known[i]);
    place[i] = static_cast<std::uint32_t>(vertices_.size());
    vertices_.push_back(known[i]);
  }
  if (vertices_.empty()) return;
  for (Triangle& t : triangles_)
    for (std::uint32_t& i : t) i = place[i];
  origin_ = 0.5 * least + 0.5 * most;
  half_extents_ = 0.5 * most - 0.5 * least;
  for (Vec3& v : vertices_) v -= origin_;
}

void TriangleMesh::index_vertices() {
  first_.assign(vertices_.size() + 1, 0);
  for (const Triangle& t : triangles_)
    for (const std::uint32_t i : t) ++first_[i + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  around_.resize(kSides * triangles_.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (const std::uint32_t i : triangles_[t]) around_[next[i]++] = static_cast<std::uint32_t>(t);
}

void TriangleMesh::drop_duplicates() {
  doubled_faces::KeptFaces kept = doubled_faces::keep_one_of_each(vertices_, triangles_, solid_);
  report_.both_sides = kept.both_sides;
  if (kept.triangles.empty()) return;
  report_.duplicate += triangles_.size() - kept.triangles.size();
  report_.opposed += kept.opposed;
  triangles_ = std::move(kept.triangles);
  index_vertices();
}

TriangleMesh::OpenEdges TriangleMesh::find_neighbours() {
  struct EdgeSide {
    std::uint32_t low, high;  // ends of the edge
    std::uint32_t side;       // index of the side: kSides * triangle + edge
  };
  const auto ends = [&](std::size_t side) {
    const Triangle& t = triangles_[side / kSides];
    return mesh_seams::Edge{t[side % kSides], t[corner_after(side % kSides)]};
  };
  const std::vector<EdgeSide> sides = bucketed<EdgeSide>(
      kSides * triangles_.size(), vertices_.size(),
      [&](std::size_t side) {
        const auto [a, b] = ends(side);
        return EdgeSide{std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(side)};
      },
      [](const EdgeSide& a, const EdgeSide& b) {
        return std::tie(a.high, a.side) < std::tie(b.high, b.side);
      });
  report_.non_manifold_edges = report_.turned_edges = 0;
  neighbours_.assign(triangles_.size(), {kNone, kNone, kNone});
  OpenEdges open;
  std::vector<bool> is_open(sides.size()), is_second(sides.size());
  for (std::size_t first = 0, end = 0; first < sides.size(); first = end) {
    while (end < sides.size() && sides[end].low == sides[first].low &&
           sides[end].high == sides[first].high)
      ++end;
    const std::uint32_t one = sides[first].side, other = sides[end - 1].side;
    if (end - first == 1 || (end - first == 2 && report_.both_sides > 0 &&
                             same_corners(one / kSides, other / kSides))) {
      is_open[one] = is_open[other] = true;
      // Two opposite triangles with the same corners have this edge twice.
      if (one != other) is_second[other] = true;
    } else if (end - first > 2) {
      ++report_.non_manifold_edges;
    } else if (ends(one)[0] == ends(other)[0]) {
      ++report_.turned_edges;
    } else {
      neighbours_[one / kSides][one % kSides] = other / kSides;
      neighbours_[other / kSides][other % kSides] = one / kSides;
    }
  }
  for (std::size_t side = 0; side < is_open.size(); ++side) {
    if (!is_open[side]) continue;
    open.sides.push_back(static_cast<std::uint32_t>(side));
    if (!is_second[side]) open.edges.push_back(ends(side));
  }
  report_.boundary_edges = open.edges.size();
  return open;
}

double TriangleMesh::volume() const {
  // This is the divergence theorem. The lengths are divided by the size, so that no product
  // overflows or underflows.
  const double size = half_extents_.maxCoeff();
  double sum = 0.0;
  for (const Triangle& t : triangles_)
    sum += (vertices_[t[0]] / size).dot((vertices_[t[1]] / size).cross(vertices_[t[2]] / size));
  return sum / 6.0 * size * size * size;
}

void TriangleMesh::turn() {
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    std::swap(triangles_[t][1], triangles_[t][2]);  // The edges 0, 1, 2 become 2, 1, 0.
    std::swap(neighbours_[t][0], neighbours_[t][2]);
  }
  report_.volume = -report_.volume;
}

std::size_t TriangleMesh::memory() const {
  return vertices_.capacity() * sizeof(Vec3) +
         (triangles_.capacity() + neighbours_.capacity()) * sizeof(Triangle) +
         (first_.capacity() + around_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace feltwire
