#include "core/mesh/mesh_surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

/// The skin (collision margin), as a share of the surface's size. The value lies between the
/// precision of single-precision coordinates in a file (24 bits) and the smallest distance that a
/// hand can feel.
constexpr double kSkin = 0x1p-22;

constexpr std::uint64_t kCornerWork = 4;  // units of work per triangle at a corner

/// Returns the box of each triangle. A triangle extends by one skin at an edge without a neighbour.
std::vector<Bounds> boxes_of(const TriangleMesh& mesh, double skin) {
  std::vector<Bounds> boxes(mesh.triangles().size());
  for (std::uint32_t t = 0; t < boxes.size(); ++t) {
    for (const Vec3& corner : mesh.corners(t)) boxes[t].add(corner);
    bool ends = false;
    for (int k = 0; k < 3; ++k) ends = ends || mesh.neighbour(t, k) == TriangleMesh::kNone;
    if (ends) boxes[t] = boxes[t].grown(skin);
  }
  return boxes;
}

/// Returns, for each triangle, the index of the first triangle of its flat face.
std::vector<std::uint32_t> faces_of(const TriangleMesh& mesh) {
  // [rad] largest angle within a flat face; above single-precision errors.
  constexpr double kFlat = 1e-3;
  constexpr std::uint32_t kNone = TriangleMesh::kNone;
  std::vector<std::uint32_t> faces(mesh.triangles().size(), kNone), open;
  for (std::uint32_t first = 0; first < faces.size(); ++first) {
    if (faces[first] != kNone) continue;
    faces[first] = first;
    open.assign(1, first);
    const Vec3 normal = triangle_normal(mesh.corners(first));
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t next = mesh.neighbour(t, k);
        if (next == kNone || faces[next] != kNone) continue;
        // Compare with the normal of the first triangle, so that small angles do not add up.
        if ((triangle_normal(mesh.corners(next)) - normal).squaredNorm() > kFlat * kFlat) continue;
        faces[next] = first;
        open.push_back(next);
      }
    }
  }
  return faces;
}

}  // namespace

// Returns the point of the triangle that is closest to p. Finds the Voronoi region of p (Ericson,
// Real-Time Collision Detection, 2005, 5.1.5).
NearestOnTriangle nearest_on_triangle(const std::array<Vec3, 3>& corners, const Vec3& p) noexcept {
  const auto& [a, b, c] = corners;
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {a, {1.0, 0.0, 0.0}, 4};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {b, {0.0, 1.0, 0.0}, 5};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double v = d1 / (d1 - d3);
    return {a + v * ab, {1.0 - v, v, 0.0}, 1};
  }
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {c, {0.0, 0.0, 1.0}, 6};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double w = d2 / (d2 - d6);
    return {a + w * ac, {1.0 - w, 0.0, w}, 3};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {b + w * (c - b), {0.0, 1.0 - w, w}, 2};
  }
  const double sum = va + vb + vc;
  const double v = vb / sum, w = vc / sum;
  return {a + v * ab + w * ac, {1.0 - v - w, v, w}, 0};
}

MeshSurface::MeshSurface(TriangleMesh mesh, const MeshOptions& options)
    : mesh_(std::move(mesh)),
      options_(options),
      skin_(kSkin * mesh_.half_extents().maxCoeff()),
      tree_(boxes_of(mesh_, skin_)),
      faces_(faces_of(mesh_)) {
  if (!options_.smooth) return;
  normals_.resize(mesh_.vertices().size());
  for (std::uint32_t v = 0; v < normals_.size(); ++v) normals_[v] = corner_normal(v);
}

Vec3 MeshSurface::corner_normal(std::uint32_t vertex, WorkLimit* work) const noexcept {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t t : mesh_.around(vertex)) {
    if (!may_go_on(work, kCornerWork)) break;
    const std::array<Vec3, 3> c = mesh_.corners(t);
    const Triangle& corner = mesh_.triangles()[t];
    const std::size_t k = corner[0] == vertex ? 0 : corner[1] == vertex ? 1 : 2;
    const Vec3 u = direction(Vec3(c[(k + 1) % 3] - c[k])),
               w = direction(Vec3(c[(k + 2) % 3] - c[k]));
    sum += std::atan2(u.cross(w).norm(), u.dot(w)) * triangle_normal(c);
  }
  return direction(sum);
}

std::optional<Crossing> MeshSurface::crossing(std::uint32_t t, const Vec3& from, const Vec3& to,
                                              std::int8_t sides) const noexcept {
  const std::array<Vec3, 3> c = mesh_.corners(t);
  const Vec3 normal = (c[1] - c[0]).cross(c[2] - c[0]);
  const double a = normal.dot(from - c[0]), b = normal.dot(to - c[0]);
  std::int8_t side = 0;
  if (sides > 0 && a >= 0.0 && b < 0.0) side = 1;
  if (sides < 0 && a <= 0.0 && b > 0.0) side = -1;
  // If contact is possible on both sides, choose a side for a point in the plane of the triangle.
  if (sides == 0 && a > 0.0 && b <= 0.0) side = 1;
  if (sides == 0 && a < 0.0 && b >= 0.0) side = -1;
  if (side == 0) return std::nullopt;

  // Test the line against each edge. Both triangles of an edge use the same expression, so that
  // rounding leaves no gap between them.
  const Vec3 way = to - from;
  const Triangle& index = mesh_.triangles()[t];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t l = (k + 1) % 3;
    const bool ascending = index[k] < index[l];
    const Vec3 first = c[ascending ? k : l] - from, second = c[ascending ? l : k] - from;
    const double turn = way.dot(first.cross(second));
    if (!(side * (ascending ? turn : -turn) > 0.0)) continue;
    // Allow one skin here, because a crack may separate two edges without a neighbour.
    if (mesh_.neighbour(t, static_cast<int>(k)) != TriangleMesh::kNone) return std::nullopt;
    const Vec3 out = (c[l] - c[k]).cross(normal);
    const Vec3 hit = from + a / (a - b) * way;
    if (!(out.dot(hit - c[k]) <= skin_ * length(out))) return std::nullopt;
  }
  return Crossing{std::clamp(a / (a - b), 0.0, 1.0), t, side};
}

std::optional<Crossing> MeshSurface::first_crossing(const Vec3& from, const Vec3& to,
                                                    std::int8_t sides,
                                                    WorkLimit* work) const noexcept {
  std::optional<Crossing> first;
  tree_.along(
      from, to,
      [&](std::uint32_t t) {
        const auto found = crossing(t, from, to, sides);
        if (!found) return;
        if (!first || found->part < first->part ||
            (found->part == first->part && t < first->triangle))
          first = found;
      },
      work);
  return first;
}

MeshSurface::NearestTriangle MeshSurface::nearest(const Vec3& p, double most,
                                                  WorkLimit* work) const noexcept {
  NearestTriangle best;
  double radius = most;
  tree_.within(
      p, [&] { return radius; },
      [&](std::uint32_t t) {
        const NearestOnTriangle here = nearest_on_triangle(mesh_.corners(t), p);
        const double distance = (p - here.point).norm();
        if (distance > radius || (distance == best.distance && t > best.triangle)) return;
        best = {t, here.point, here.weights, distance};
        radius = distance;
      },
      work);
  return best;
}

double MeshSurface::side_of(const Vec3& p, const NearestTriangle& nearest,
                            WorkLimit* work) const noexcept {
  const Triangle& corner = mesh_.triangles()[nearest.triangle];
  Vec3 normal = triangle_normal(mesh_.corners(nearest.triangle));
  std::size_t zeros = 0, zero = 0, one = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (nearest.weights[static_cast<Eigen::Index>(k)] > 0.0) {
      one = k;
    } else {
      ++zeros;
      zero = k;
    }
  }
  if (zeros == 2) {
    normal = corner_normal(corner[one], work);
  } else if (zeros == 1) {  // The nearest point is on the opposite edge.
    const std::uint32_t other = mesh_.neighbour(nearest.triangle, static_cast<int>((zero + 1) % 3));
    if (other != TriangleMesh::kNone) normal += triangle_normal(mesh_.corners(other));
  }
  return normal.dot(p - nearest.point);
}

std::size_t MeshSurface::memory() const {
  return mesh_.memory() + tree_.memory() + normals_.capacity() * sizeof(Vec3) +
         faces_.capacity() * sizeof(std::uint32_t);
}

}  // namespace feltwire
