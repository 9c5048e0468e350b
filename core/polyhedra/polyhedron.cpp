#include "core/polyhedra/polyhedron.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/convex/hull_triangles.hpp"

namespace feltwire {
namespace {

struct Bound {
  Vec3 least, most;
};

Bound bound(const std::vector<Vec3>& points) {
  Bound b{points.front(), points.front()};
  for (const Vec3& p : points) {
    b.least = b.least.cwiseMin(p);
    b.most = b.most.cwiseMax(p);
  }
  return b;
}

/// Returns the planes without duplicates.
std::vector<HalfSpaceBelow> distinct(const std::vector<HalfSpaceBelow>& planes, double size) {
  constexpr double kSameNormal = 1e-7;
  std::vector<HalfSpaceBelow> kept;
  for (const HalfSpaceBelow& plane : planes) {
    const bool known = std::ranges::any_of(kept, [&](const HalfSpaceBelow& other) {
      return (plane.normal - other.normal).norm() < kSameNormal &&
             std::abs(plane.offset - other.offset) < kSameNormal * size;
    });
    if (!known) kept.push_back(plane);
  }
  return kept;
}

/// Returns the vertices on a plane, counter-clockwise about its normal.
std::vector<std::uint32_t> ring(const std::vector<Vec3>& vertices, const HalfSpaceBelow& plane,
                                double on) {
  std::vector<std::uint32_t> found;
  Vec3 middle = Vec3::Zero();
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (std::abs(plane.normal.dot(vertices[v]) - plane.offset) <= on) {
      found.push_back(static_cast<std::uint32_t>(v));
      middle += vertices[v];
    }
  if (found.size() < 3) return {};
  middle /= static_cast<double>(found.size());
  const Vec3 across = plane.normal.unitOrthogonal(), along = plane.normal.cross(across);
  std::vector<std::pair<double, std::uint32_t>> angles;
  for (const std::uint32_t v : found) {
    const Vec3 arm = vertices[v] - middle;
    angles.emplace_back(std::atan2(arm.dot(along), arm.dot(across)), v);
  }
  std::ranges::sort(angles);
  for (std::size_t i = 0; i < found.size(); ++i) found[i] = angles[i].second;
  return found;
}

struct Face {
  HalfSpaceBelow plane;
  std::vector<std::uint32_t> corners;

  bool holds(const Face& other) const {
    return std::ranges::all_of(other.corners, [&](std::uint32_t v) {
      return std::ranges::find(corners, v) != corners.end();
    });
  }
};

/// Returns the faces on the planes. A narrow face may lie in the plane of a wide face, except for
/// rounding errors. Then both planes have the same corners, and only one plane remains.
std::vector<Face> faces(const std::vector<Vec3>& vertices,
                        const std::vector<HalfSpaceBelow>& planes, double on) {
  std::vector<Face> found;
  for (const HalfSpaceBelow& plane : planes) {
    Face face{plane, ring(vertices, plane, on)};
    if (face.corners.empty() ||
        std::ranges::any_of(found, [&](const Face& other) { return other.holds(face); }))
      continue;
    std::erase_if(found, [&](const Face& other) { return face.holds(other); });
    found.push_back(std::move(face));
  }
  return found;
}

/// Returns the faces as Qhull merged them: connected triangles in one plane. Returns an empty list
/// if the rim of a face is not one ring.
std::vector<Face> joined_faces(const HullTriangles& hull) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> triangle_of;
  for (std::size_t t = 0; t < hull.corners.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      triangle_of[{hull.corners[t][k], hull.corners[t][(k + 1) % 3]}] = t;
  const auto same_face = [&](std::size_t a, std::size_t b) {
    return hull.planes[a].normal == hull.planes[b].normal &&
           hull.planes[a].offset == hull.planes[b].offset;
  };
  std::vector<Face> found;
  std::vector<std::uint8_t> taken(hull.corners.size(), 0);
  for (std::size_t first = 0; first < hull.corners.size(); ++first) {
    if (taken[first] != 0) continue;
    taken[first] = 1;
    std::map<std::uint32_t, std::uint32_t> next;  // next vertex along the rim
    std::vector<std::size_t> waiting = {first};
    while (!waiting.empty()) {
      const std::size_t t = waiting.back();
      waiting.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = hull.corners[t][k], b = hull.corners[t][(k + 1) % 3];
        const auto beyond = triangle_of.find({b, a});
        if (beyond == triangle_of.end()) return {};
        if (!same_face(first, beyond->second)) {
          if (!next.try_emplace(a, b).second) return {};
        } else if (taken[beyond->second] == 0) {
          taken[beyond->second] = 1;
          waiting.push_back(beyond->second);
        }
      }
    }
    if (next.size() < 3) return {};
    Face face{hull.planes[first], {}};
    std::uint32_t at = next.begin()->first;
    do {
      face.corners.push_back(at);
      const auto step = next.find(at);
      if (step == next.end()) return {};
      at = step->second;
    } while (at != face.corners.front() && face.corners.size() <= next.size());
    if (face.corners.size() != next.size()) return {};
    found.push_back(std::move(face));
  }
  return found;
}

/// Finds the two faces of each edge. Returns false if an edge does not have exactly two faces.
bool join_faces(Polyhedron& solid) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> face_of;
  for (std::size_t f = 0; f < solid.planes.size(); ++f) {
    const auto face = solid.face(f);
    for (std::size_t k = 0; k < face.size(); ++k)
      if (!face_of.try_emplace({face[k], face[(k + 1) % face.size()]}, f).second) return false;
  }
  for (const auto& [ends, left] : face_of) {
    const auto twin = face_of.find({ends.second, ends.first});
    if (twin == face_of.end()) return false;
    if (ends.first < ends.second)
      solid.edges.push_back({ends.first, ends.second, left, twin->second});
  }
  return true;
}

}  // namespace

std::vector<Vec3> fewer_corners(const std::vector<Vec3>& corners, double error) {
  std::vector<Vec3> kept;
  std::vector<std::uint8_t> is_kept(corners.size(), 0);
  const auto keep = [&](std::size_t i) {
    if (is_kept[i] != 0) return;
    is_kept[i] = 1;
    kept.push_back(corners[i]);
  };
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 1, 1),
                          Vec3(1, -1, 1), Vec3(1, 1, -1), Vec3(1, -1, -1)}) {
    const auto along = [&](const Vec3& p) { return way.dot(p); };
    const auto [least, most] = std::ranges::minmax_element(corners, {}, along);
    keep(static_cast<std::size_t>(least - corners.begin()));
    keep(static_cast<std::size_t>(most - corners.begin()));
  }
  while (kept.size() < std::min(corners.size(), kMostFewCorners)) {
    const auto hull = convex_hull(kept);
    double farthest = hull ? error : -1.0;
    std::size_t at = corners.size();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (is_kept[i] != 0) continue;
      double out = 0.0;
      for (std::size_t k = 0; hull && k < hull->planes.size(); ++k)
        out = std::max(out, hull->planes[k].normal.dot(corners[i]) - hull->planes[k].offset);
      if (!(out > farthest)) continue;
      farthest = out;
      at = i;
    }
    if (at == corners.size()) break;
    keep(at);
  }
  return kept;
}

namespace {

/// Builds the solid from these faces. Returns false if the faces do not form a closed surface.
bool take_faces(const std::vector<Face>& faces, Polyhedron& solid) {
  solid.planes.clear();
  solid.first = {0};
  solid.loop.clear();
  solid.edges.clear();
  for (const auto& [plane, corners] : faces) {
    solid.planes.push_back(plane);
    solid.loop.insert(solid.loop.end(), corners.begin(), corners.end());
    solid.first.push_back(static_cast<std::uint32_t>(solid.loop.size()));
  }
  if (faces.empty() || !join_faces(solid)) return false;
  solid.graph = corner_graph(solid.vertices.size(), solid.first, solid.loop);
  solid.centre = 0.5 * (solid.least + solid.most);
  for (const Vec3& v : solid.vertices)
    solid.radius = std::max(solid.radius, (v - solid.centre).norm());
  return true;
}

}  // namespace

Polyhedron polyhedron(std::span<const Vec3> points) {
  const auto hull = convex_hull(points);
  if (!hull)
    throw std::invalid_argument("a convex part has no volume; give a solid, not a flat surface");
  if (hull->vertices.size() > kMostPolyhedronVertices)
    throw std::invalid_argument(
        "a convex part has " + std::to_string(hull->vertices.size()) + " corners, more than " +
        std::to_string(kMostPolyhedronVertices) +
        "; simplify the mesh: one that is convex is taken as it is, with all its corners");
  Polyhedron solid;
  solid.vertices = hull->vertices;
  const Bound box = bound(solid.vertices);
  solid.least = box.least;
  solid.most = box.most;
  const double size = (box.most - box.least).maxCoeff();
  // Qhull merges nearly coplanar faces, so a corner may be `on` [m] off its face.
  for (const double on : {kCoplanar * size, 1e2 * kCoplanar * size, 1e4 * kCoplanar * size})
    if (take_faces(faces(solid.vertices, distinct(hull->planes, size), on), solid)) return solid;
  if (take_faces(joined_faces(hull_triangles(points)), solid)) return solid;
  throw std::invalid_argument(
      "the faces of a convex part do not close, because its corners are nearly in one plane; "
      "simplify the mesh");
}

}  // namespace feltwire
