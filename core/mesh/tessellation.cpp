#include "core/mesh/tessellation.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace feltwire {
namespace {

/// The middle of an edge on the unit sphere; each edge has one.
std::uint32_t middle(std::uint32_t a, std::uint32_t b, std::vector<Vec3>& vertices,
                     std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>& known) {
  const auto [place, is_new] =
      known.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices.size()));
  if (is_new) vertices.push_back((vertices[a] + vertices[b]).normalized());
  return place->second;
}

/// A point of a profile that is turned about z.
struct Profile {
  double radius, z;  // [m]
};

/// The surface of revolution of a profile that begins and ends on the axis, from the top down.
TriangleSoup revolved(const std::vector<Profile>& profile, int segments) {
  TriangleSoup soup;
  const auto n = static_cast<std::uint32_t>(segments);
  const auto rings = static_cast<std::uint32_t>(profile.size() - 2);
  soup.vertices.emplace_back(0.0, 0.0, profile.front().z);
  for (std::uint32_t ring = 1; ring <= rings; ++ring)
    for (std::uint32_t i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / n;
      const Profile& p = profile[ring];
      soup.vertices.emplace_back(p.radius * std::cos(angle), p.radius * std::sin(angle), p.z);
    }
  soup.vertices.emplace_back(0.0, 0.0, profile.back().z);
  const auto last = static_cast<std::uint32_t>(soup.vertices.size() - 1);
  const auto at = [&](std::uint32_t ring, std::uint32_t i) { return 1 + (ring - 1) * n + i % n; };
  for (std::uint32_t i = 0; i < n; ++i) {
    soup.triangles.push_back({0, at(1, i), at(1, i + 1)});
    for (std::uint32_t ring = 1; ring < rings; ++ring) {
      soup.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)});
      soup.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)});
    }
    soup.triangles.push_back({last, at(rings, i + 1), at(rings, i)});
  }
  return soup;
}

/// Half a circle about the origin cut at its equator, its halves moved apart.
std::vector<Profile> capsule_profile(double radius, double half_length, int segments) {
  const int quarter = std::max(1, segments / 4);
  std::vector<Profile> profile;
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i <= quarter; ++i) {
      if (half == 1 && i == 0 && half_length == 0.0) continue;  // the equator is there already
      const double angle =
          0.5 * std::numbers::pi * (half + static_cast<double>(i) / quarter);  // from the top
      profile.push_back({radius * std::sin(angle),
                         radius * std::cos(angle) + (half == 0 ? half_length : -half_length)});
    }
  return profile;
}

TriangleSoup box(const Vec3& h) {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i)
    soup.vertices.emplace_back((i & 1) != 0 ? h.x() : -h.x(), (i & 2) != 0 ? h.y() : -h.y(),
                               (i & 4) != 0 ? h.z() : -h.z());
  soup.triangles = {{1, 3, 7}, {1, 7, 5}, {0, 4, 6}, {0, 6, 2}, {2, 6, 7}, {2, 7, 3},
                    {0, 1, 5}, {0, 5, 4}, {4, 5, 7}, {4, 7, 6}, {0, 2, 3}, {0, 3, 1}};
  return soup;
}

struct Tessellate {
  int segments;
  [[noreturn]] static void refuse(const char* what) {
    throw std::invalid_argument(std::string(what) +
                                " has no surface to cut into triangles; take "
                                "another shape");
  }
  TriangleSoup operator()(const Plane&) const { refuse("a plane"); }
  TriangleSoup operator()(const Mesh&) const { refuse("a mesh"); }
  TriangleSoup operator()(const Grid&) const { refuse("a grid"); }
  TriangleSoup operator()(const Box& b) const { return box(b.half_extents); }
  TriangleSoup operator()(const Sphere& s) const {
    return revolved(capsule_profile(s.radius, 0.0, segments), segments);
  }
  TriangleSoup operator()(const Capsule& c) const {
    return revolved(capsule_profile(c.radius, c.half_length, segments), segments);
  }
  TriangleSoup operator()(const Cylinder& c) const {
    return revolved({{0.0, c.half_length},
                     {c.radius, c.half_length},
                     {c.radius, -c.half_length},
                     {0.0, -c.half_length}},
                    segments);
  }
};

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
  return std::visit(Tessellate{segments}, shape);
}

}  // namespace feltwire
