#pragma once
// Surfaces with a known closed form, as triangles.

#include <cmath>
#include <memory>

#include "core/contact/contact.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire::test {

using feltwire::icosphere;

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

/// Joins two surfaces into one.
inline TriangleSoup joined(TriangleSoup a, const TriangleSoup& b) {
  const auto base = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles)
    a.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return a;
}

inline Object mesh_object(const TriangleSoup& soup, const MeshOptions& options = {},
                          const Material& material = {}, Side side = Side::outside) {
  Object o;
  o.name = "mesh";
  o.shape = Mesh{std::make_shared<MeshSurface>(TriangleMesh(soup), options)};
  o.felt_from = side;
  o.material = material;
  return o;
}

}  // namespace feltwire::test
