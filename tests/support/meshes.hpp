#pragma once
// Surfaces whose shape is known in closed form, as triangles.

#include <cmath>
#include <map>
#include <utility>

#include "core/geometry/triangle_mesh.hpp"

namespace feltwire::test {

/// Sphere about the origin [m], 20 * 4^level triangles, all corners on it.
inline TriangleSoup icosphere(double radius, int level) {
  const double phi = 0.5 * (1.0 + std::sqrt(5.0));
  TriangleSoup s;
  s.vertices = {{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0},
                {0, -1, phi}, {0, 1, phi}, {0, -1, -phi}, {0, 1, -phi},
                {phi, 0, -1}, {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
  for (Vec3& v : s.vertices) v = radius * v.normalized();
  s.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, added] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(s.vertices.size()));
      if (added) s.vertices.push_back(radius * (s.vertices[a] + s.vertices[b]).normalized());
      return at->second;
    };
    std::vector<Triangle> finer;
    finer.reserve(4 * s.triangles.size());
    for (const auto& [a, b, c] : s.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.push_back({a, ab, ca});
      finer.push_back({b, bc, ab});
      finer.push_back({c, ca, bc});
      finer.push_back({ab, bc, ca});
    }
    s.triangles = std::move(finer);
  }
  return s;
}

/// Box about the origin, each face cut into n x n squares of two triangles.
inline TriangleSoup box(const Vec3& half, int n = 1) {
  TriangleSoup s;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double sign = face % 2 == 0 ? 1.0 : -1.0;
    const Vec3 w = sign * Vec3::Unit(axis), u = Vec3::Unit((axis + 1) % 3), v = w.cross(u);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const auto at = [&](int a, int b) {
          const Vec3 p = w + (2.0 * a - n) / n * u + (2.0 * b - n) / n * v;
          s.vertices.push_back(p.cwiseProduct(half));
          return static_cast<std::uint32_t>(s.vertices.size() - 1);
        };
        const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
        s.triangles.push_back({a, b, c});
        s.triangles.push_back({a, c, d});
      }
  }
  return s;
}

/// Torus about the z axis: `ring` [m] from the axis to the tube's middle, `tube` its radius.
inline TriangleSoup torus(double ring, double tube, int around, int across) {
  TriangleSoup s;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2.0 * M_PI * i / around, v = 2.0 * M_PI * j / across;
      const double r = ring + tube * std::cos(v);
      s.vertices.emplace_back(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
    }
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>((i % around) * across + j % across);
  };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return s;
}

/// Rectangle in the plane z = 0 about the origin, outside up, n x n squares of two triangles.
inline TriangleSoup sheet(double half, int n = 1) {
  TriangleSoup s;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      s.vertices.emplace_back(half * (2.0 * i / n - 1.0), half * (2.0 * j / n - 1.0), 0.0);
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return s;
}

inline TriangleSoup moved(TriangleSoup s, const Vec3& by, double scale = 1.0) {
  for (Vec3& v : s.vertices) v = scale * v + by;
  return s;
}

/// Two surfaces as one.
inline TriangleSoup joined(TriangleSoup a, const TriangleSoup& b) {
  const auto base = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles)
    a.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return a;
}

}  // namespace feltwire::test
