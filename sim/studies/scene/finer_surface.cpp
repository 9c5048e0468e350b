#include "sim/studies/scene/finer_surface.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace feltwire {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // two vertex indices in ascending order

Edge edge(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// Returns the normals at the vertices: the area-weighted mean of the normals of the adjacent
/// triangles.
std::vector<Vec3> normals(const TriangleSoup& surface) {
  std::vector<Vec3> all(surface.vertices.size(), Vec3::Zero());
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3& at = surface.vertices[a];
    const Vec3 area = (surface.vertices[b] - at).cross(surface.vertices[c] - at);
    for (const std::uint32_t v : {a, b, c}) all[v] += area;
  }
  for (Vec3& normal : all) normal.normalize();
  return all;
}

/// Returns the longest edges of a surface, each edge once, and at most `most` edges.
std::vector<Edge> longest(const TriangleSoup& surface, std::size_t most) {
  std::vector<std::pair<double, Edge>> edges;
  for (const auto& corners : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge e = edge(corners[k], corners[(k + 1) % 3]);
      edges.emplace_back(-(surface.vertices[e.second] - surface.vertices[e.first]).norm(), e);
    }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<Edge> result;
  for (std::size_t i = 0; i < std::min(most, edges.size()); ++i) result.push_back(edges[i].second);
  return result;
}

/// Returns the surface with a new vertex in the middle of each edge in `halved`. Each of these
/// edges adds two triangles.
TriangleSoup with_halved(const TriangleSoup& surface, const std::vector<Edge>& halved) {
  const std::vector<Vec3> normal = normals(surface);
  TriangleSoup finer{surface.vertices, {}};
  std::map<Edge, std::uint32_t> middles;
  for (const auto& [a, b] : halved) {
    const Vec3 &from = surface.vertices[a], &to = surface.vertices[b];
    const Vec3 way = to - from;
    middles[{a, b}] = static_cast<std::uint32_t>(finer.vertices.size());
    finer.vertices.push_back(0.5 * (from + to) - 0.125 * (way.dot(normal[a]) * normal[a] -
                                                          way.dot(normal[b]) * normal[b]));
  }
  const auto middle = [&](std::uint32_t a, std::uint32_t b) -> std::optional<std::uint32_t> {
    const auto found = middles.find(edge(a, b));
    return found == middles.end() ? std::nullopt : std::optional(found->second);
  };
  for (auto [a, b, c] : surface.triangles) {
    auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    // Rotate the order of the corners so that the halved edges come first.
    while ((!ab && (bc || ca)) || (ab && !bc && ca)) {
      std::tie(a, b, c) = std::tuple(b, c, a);
      std::tie(ab, bc, ca) = std::tuple(bc, ca, ab);
    }
    auto& to = finer.triangles;
    if (!ab) {
      to.push_back({a, b, c});
    } else if (!bc) {
      to.push_back({a, *ab, c});
      to.push_back({*ab, b, c});
    } else if (!ca) {
      to.push_back({*ab, b, *bc});
      to.push_back({a, *ab, *bc});
      to.push_back({a, *bc, c});
    } else {
      to.push_back({a, *ab, *ca});
      to.push_back({*ab, b, *bc});
      to.push_back({*ca, *bc, c});
      to.push_back({*ab, *bc, *ca});
    }
  }
  return finer;
}

}  // namespace

TriangleSoup finer_surface(TriangleSoup surface, std::size_t triangles) {
  while (surface.triangles.size() < triangles)
    surface =
        with_halved(surface, longest(surface, (triangles - surface.triangles.size() + 1) / 2));
  return surface;
}

}  // namespace feltwire
