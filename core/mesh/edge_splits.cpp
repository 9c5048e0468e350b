#include "core/mesh/edge_splits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "core/mesh/box_tree.hpp"

namespace feltwire::edge_splits {
namespace {

constexpr std::uint32_t kSides = 3;
// Largest distance of a vertex from its edge, as a share of a part's size.
constexpr double kPart = 0.25;
/// Least relative height of a part of a triangle, well above rounding errors.
constexpr double kLeastHeight = 1e-12;
// Largest number of candidates to test. Testing them takes some seconds.
constexpr std::size_t kMostLooked = std::size_t{1} << 27;

/// A vertex that lies on an open edge.
struct OnEdge {
  std::uint32_t place;  // index of the edge in open_
  double along;         // position along the edge, 0 to 1
  std::uint32_t vertex;
  double off;  // [m] distance from the edge
};

class Search {
 public:
  Search(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
         std::span<const std::uint32_t> open, double weld)
      : vertices_(vertices), triangles_(triangles), open_(open), weld_(weld) {}

  /// Returns the vertices that lie on open edges, sorted by edge and by position along the edge.
  /// Sets `all` to false if the search stopped early.
  std::vector<OnEdge> run(bool& all) {
    const BoxTree tree(boxes());
    std::vector<std::uint32_t> ends;
    for (const std::uint32_t side : open_) {
      const auto [a, b] = ends_of(side);
      ends.push_back(a);
      ends.push_back(b);
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());

    std::vector<OnEdge> found;
    std::size_t looked = 0;
    for (const std::uint32_t v : ends) {
      Bounds here;
      here.add(vertices_[v]);
      tree.overlapping(here, [&](std::uint32_t box) {
        ++looked;
        if (const auto on = place_on(pieces_[box], v)) found.push_back(*on);
      });
      all = looked <= kMostLooked;
      if (!all) break;
    }
    std::sort(found.begin(), found.end(), [](const OnEdge& x, const OnEdge& y) {
      return std::tie(x.place, x.along, x.vertex) < std::tie(y.place, y.along, y.vertex);
    });
    return found;
  }

  std::array<std::uint32_t, 2> ends_of(std::uint32_t side) const {
    const Triangle& t = triangles_[side / kSides];
    return {t[side % kSides], t[corner_after(side % kSides)]};
  }
  double length_of(std::uint32_t side) const {
    const auto [a, b] = ends_of(side);
    return (vertices_[b] - vertices_[a]).norm();
  }

 private:
  /// Returns boxes around pieces of the edges. A box around a long diagonal edge would overlap
  /// everything. There are at most twice as many boxes as edges.
  std::vector<Bounds> boxes() {
    double whole = 0.0;
    for (const std::uint32_t side : open_) whole += length_of(side);
    std::vector<Bounds> boxes;
    for (std::uint32_t place = 0; place < open_.size(); ++place) {
      const auto [a, b] = ends_of(open_[place]);
      const Vec3 &from = vertices_[a], &to = vertices_[b];
      // The square of a length below 1e-154 m underflows to zero. Such an edge stays one piece.
      const double share =
          whole > 0.0 ? (to - from).norm() / whole * static_cast<double>(open_.size()) : 1.0;
      const int pieces = static_cast<int>(std::clamp(std::ceil(share), 1.0, 1e6));
      for (int i = 0; i < pieces; ++i) {
        Bounds box;
        box.add(from + static_cast<double>(i) / pieces * (to - from));
        box.add(i + 1 == pieces ? to : Vec3(from + (i + 1.0) / pieces * (to - from)));
        boxes.push_back(box.grown(weld_));
        pieces_.push_back(place);
      }
    }
    return boxes;
  }

  std::optional<OnEdge> place_on(std::uint32_t place, std::uint32_t v) const {
    const std::uint32_t side = open_[place];
    const Triangle& t = triangles_[side / kSides];
    if (v == t[0] || v == t[1] || v == t[2]) return std::nullopt;
    const auto [a, b] = ends_of(side);
    const Vec3 edge = vertices_[b] - vertices_[a], way = vertices_[v] - vertices_[a];
    const double length = edge.norm();
    if (!(length > 0.0)) return std::nullopt;
    const Vec3 u = edge / length;
    const double along = u.dot(way);
    const double off = (way - along * u).norm();
    if (!(along > 0.0 && along < length) || !(off <= weld_)) return std::nullopt;
    const Vec3 apex = vertices_[t[corner_after(corner_after(side % kSides))]] - vertices_[a];
    const double height = (apex - u.dot(apex) * u).norm();
    const double part = std::min(along, length - along);
    if (off > kPart * std::min(height, part)) return std::nullopt;
    const double longest = std::max({length, apex.norm(), (apex - edge).norm()});
    if (part / length * (height / longest) < kLeastHeight) return std::nullopt;
    return OnEdge{place, along / length, v, off};
  }

  std::span<const Vec3> vertices_;
  std::span<const Triangle> triangles_;
  std::span<const std::uint32_t> open_;
  double weld_;
  std::vector<std::uint32_t> pieces_;  // index of an edge in open_, for each box
};

/// Returns the vertices on one edge, without vertices that are too close to the previous vertex.
std::vector<OnEdge> apart(std::span<const OnEdge> corners, double length) {
  std::vector<OnEdge> kept;
  for (const OnEdge& corner : corners) {
    if (!kept.empty() && (corner.along - kept.back().along) * length * kPart <=
                             std::max({corner.off, kept.back().off, kLeastHeight * length}))
      continue;
    kept.push_back(corner);
  }
  return kept;
}

using Part = std::pair<std::uint32_t, std::uint32_t>;
Part part_between(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

Split split(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
            std::span<const std::uint32_t> open, double weld) {
  Split result;
  if (open.empty()) return result;
  Search search(vertices, triangles, open, weld);
  const std::vector<OnEdge> found = search.run(result.all_looked);
  if (found.empty()) return result;

  std::vector<std::vector<OnEdge>> corners(open.size());
  for (std::size_t begin = 0, end = 0; begin < found.size(); begin = end) {
    while (end < found.size() && found[end].place == found[begin].place) ++end;
    const std::uint32_t place = found[begin].place;
    corners[place] =
        apart(std::span(found).subspan(begin, end - begin), search.length_of(open[place]));
  }

  const auto for_each_part = [&](std::uint32_t place, const auto& take) {
    const auto [a, b] = search.ends_of(open[place]);
    std::uint32_t from = a;
    for (const OnEdge& corner : corners[place]) {
      take(part_between(from, corner.vertex));
      from = corner.vertex;
    }
    take(part_between(from, b));
  };
  std::vector<Part> parts;
  for (std::uint32_t place = 0; place < open.size(); ++place)
    for_each_part(place, [&](const Part& part) { parts.push_back(part); });
  std::sort(parts.begin(), parts.end());
  const auto meets = [&](const Part& part) {
    const auto [first, last] = std::equal_range(parts.begin(), parts.end(), part);
    return last - first > 1;
  };

  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  // Index of the edge to split, by triangle.
  std::vector<std::uint32_t> split_at(triangles.size(), kNone);
  for (std::uint32_t place = 0; place < open.size(); ++place) {
    std::uint32_t& here = split_at[open[place] / kSides];
    if (corners[place].empty() || here != kNone) continue;
    bool useful = false;
    for_each_part(place, [&](const Part& part) { useful = useful || meets(part); });
    if (!useful) continue;
    here = place;
    ++result.edges;
  }
  if (result.edges == 0) return result;
  result.triangles.reserve(triangles.size() + found.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (split_at[t] == kNone) {
      result.triangles.push_back(triangles[t]);
      continue;
    }
    const std::uint32_t place = split_at[t];
    const auto [a, b] = search.ends_of(open[place]);
    const std::uint32_t apex = triangles[t][corner_after(corner_after(open[place] % kSides))];
    std::uint32_t from = a;
    for (const OnEdge& corner : corners[place]) {
      result.triangles.push_back({from, corner.vertex, apex});
      result.farthest = std::max(result.farthest, corner.off);
      from = corner.vertex;
    }
    result.triangles.push_back({from, b, apex});
  }
  return result;
}

}  // namespace feltwire::edge_splits
