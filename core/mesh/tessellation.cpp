#include "core/mesh/tessellation.hpp"

#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace feltwire {
namespace {

/// Returns the index of the vertex at the middle of an edge, on the unit sphere. Makes this vertex
/// only once for each edge.
std::uint32_t middle(std::uint32_t a, std::uint32_t b, std::vector<Vec3>& vertices,
                     std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>& known) {
  const auto [place, is_new] =
      known.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices.size()));
  if (is_new) vertices.push_back((vertices[a] + vertices[b]).normalized());
  return place->second;
}

}  // namespace

TriangleSoup icosphere(double radius, int level) {
  const double t = 0.5 * (1.0 + std::sqrt(5.0));
  TriangleSoup soup;
  soup.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  for (Vec3& v : soup.vertices) v.normalize();
  soup.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int i = 0; i < level; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> known;
    std::vector<Triangle> finer;
    finer.reserve(4 * soup.triangles.size());
    for (const auto& [a, b, c] : soup.triangles) {
      const std::uint32_t ab = middle(a, b, soup.vertices, known),
                          bc = middle(b, c, soup.vertices, known),
                          ca = middle(c, a, soup.vertices, known);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    soup.triangles = std::move(finer);
  }
  for (Vec3& v : soup.vertices) v *= radius;
  return soup;
}

TriangleSoup tessellate(const Shape& shape, int segments) {
  if (segments < 3)
    throw std::invalid_argument("segments: must be at least 3, is " + std::to_string(segments) +
                                "; give a larger number");
  const char* what = std::holds_alternative<Mesh>(shape) ? "mesh" : "grid";
  TriangleSoup soup = on_primitive(
      shape,
      [&](const auto& solid) {
        what = solid.kName;
        return solid.triangles(segments);
      },
      [] { return TriangleSoup{}; });
  if (soup.triangles.empty())
    throw std::invalid_argument("a " + std::string(what) +
                                " has no surface to cut into triangles; take another shape");
  return soup;
}

}  // namespace feltwire
