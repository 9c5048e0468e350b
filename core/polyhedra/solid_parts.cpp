#include "core/polyhedra/solid_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>

#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/polyhedra/clipped_polyhedron.hpp"

namespace feltwire {
namespace {

bool boxes_meet(const Polyhedron& a, const Polyhedron& b, double slack) {
  return ((a.least.array() - slack) <= b.most.array()).all() &&
         ((b.least.array() - slack) <= a.most.array()).all();
}

bool holds(const Polyhedron& solid, const Vec3& p) {
  if ((p.array() < solid.least.array()).any() || (p.array() > solid.most.array()).any())
    return false;
  return std::ranges::all_of(solid.planes, [&](const HalfSpaceBelow& plane) {
    return plane.normal.dot(p) <= plane.offset;
  });
}

/// Returns true if a face lies within the other parts. Tests the middle of the face and the points
/// halfway to its corners, all moved slightly outwards.
bool is_inner(const std::vector<SolidPart>& parts, std::size_t own, std::size_t face, double out) {
  const Polyhedron& shape = parts[own].shape;
  const auto loop = shape.face(face);
  Vec3 middle = Vec3::Zero();
  for (const std::uint32_t v : loop) middle += shape.vertices[v];
  middle /= static_cast<double>(loop.size());
  const auto is_within = [&](const Vec3& on_face) {
    const Vec3 p = on_face + out * shape.planes[face].normal;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (i != own && holds(parts[i].shape, p)) return true;
    return false;
  };
  if (!is_within(middle)) return false;
  constexpr double kTowardsCorner = 0.9;
  return std::ranges::all_of(loop, [&](std::uint32_t v) {
    return is_within(middle + kTowardsCorner * (shape.vertices[v] - middle)) &&
           is_within(0.5 * (middle + shape.vertices[v]));
  });
}

/// Removes from part.beyond each plane that is the nearest surface for no point of the part.
void keep_nearest(SolidPart& part) {
  const auto depth = [&](const HalfSpaceBelow& plane) {
    return plane.offset - plane.normal.dot(part.shape.centre);
  };
  std::ranges::sort(part.beyond, {}, depth);
  std::vector<HalfSpaceBelow> nearer;
  for (std::size_t f = 0; f < part.inner.size(); ++f)
    if (part.inner[f] == 0) nearer.push_back(part.shape.planes[f]);
  std::ranges::sort(nearer, {}, depth);
  const auto whole = std::make_unique<ClippedPolyhedron>();
  whole->assign(part.shape, Mat3::Identity(), Vec3::Zero());
  const auto cell = std::make_unique<ClippedPolyhedron>();
  std::erase_if(part.beyond, [&](const HalfSpaceBelow& plane) {
    *cell = *whole;
    for (const HalfSpaceBelow& other : nearer)
      if (!cell->cut(other.normal - plane.normal, other.offset - plane.offset, 0)) return true;
    nearer.push_back(plane);
    return false;
  });
}

/// Adds to part.beyond each plane of the neighbours' surfaces that has the part behind it.
void look_beyond(std::vector<SolidPart>& parts, std::size_t own, double slack) {
  SolidPart& part = parts[own];
  if (std::ranges::count(part.inner, 1) == 0) return;
  constexpr double kSameNormal = 1e-6;
  const auto is_known = [&](const HalfSpaceBelow& plane) {
    const auto same = [&](const HalfSpaceBelow& other) {
      return (plane.normal - other.normal).norm() < kSameNormal &&
             std::abs(plane.offset - other.offset) < slack;
    };
    return std::ranges::any_of(part.shape.planes, same) || std::ranges::any_of(part.beyond, same);
  };
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i == own || !boxes_meet(part.shape, parts[i].shape, slack)) continue;
    for (std::size_t f = 0; f < parts[i].shape.planes.size(); ++f) {
      const HalfSpaceBelow& plane = parts[i].shape.planes[f];
      const bool behind = std::ranges::all_of(part.shape.vertices, [&](const Vec3& v) {
        return plane.normal.dot(v) <= plane.offset + slack;
      });
      if (parts[i].inner[f] == 0 && behind && !is_known(plane)) part.beyond.push_back(plane);
    }
  }
  keep_nearest(part);
}

SolidParts one_part(std::span<const Vec3> corners, bool hollow) {
  SolidParts solid;
  solid.hollow = hollow;
  SolidPart& part = solid.parts.emplace_back();
  part.shape = polyhedron(corners);
  part.inner.assign(part.shape.planes.size(), 0);
  solid.centre = part.shape.centre;
  solid.radius = part.shape.radius;
  return solid;
}

SolidParts half_space(bool hollow) {
  SolidParts solid;
  solid.hollow = hollow;
  SolidPart& part = solid.parts.emplace_back();
  part.shape.planes = {{Vec3::UnitZ(), 0.0}};
  part.inner = {0};
  part.shape.radius = solid.radius = std::numeric_limits<double>::infinity();
  return solid;
}

bool is_convex_mesh(const TriangleMesh& mesh) {
  const double slack = kCoplanar * mesh.report().size;
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    const auto corners = mesh.corners(t);
    const Vec3 normal = triangle_normal(corners);
    for (const std::uint32_t v : mesh.triangles()[t])
      for (const std::uint32_t near : mesh.around(v))
        for (const Vec3& p : mesh.corners(near))
          if (normal.dot(p - corners[0]) > slack) return false;
  }
  return mesh.report().closed();
}

}  // namespace

SolidParts solid_parts(const std::vector<std::vector<Vec3>>& corners) {
  if (corners.empty()) throw std::invalid_argument("has no convex parts; mend the mesh");
  SolidParts solid;
  solid.parts.resize(corners.size());
  Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity()), most = -least;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Polyhedron& shape = solid.parts[i].shape;
    shape = polyhedron(corners[i]);
    least = least.cwiseMin(shape.least);
    most = most.cwiseMax(shape.most);
  }
  solid.centre = 0.5 * (least + most);
  for (const SolidPart& part : solid.parts)
    for (const Vec3& v : part.shape.vertices)
      solid.radius = std::max(solid.radius, (v - solid.centre).norm());
  constexpr double kOut = 1e-7, kSlack = 1e-6;  // shares of the solid's size
  const double size = (most - least).maxCoeff();
  for (std::size_t i = 0; i < solid.parts.size(); ++i) {
    SolidPart& part = solid.parts[i];
    part.inner.assign(part.shape.planes.size(), 0);
    for (std::size_t f = 0; f < part.inner.size(); ++f)
      part.inner[f] = is_inner(solid.parts, i, f, kOut * size) ? 1 : 0;
    // If the part is wholly within the other parts, measure the depth below its own faces.
    if (std::ranges::count(part.inner, 0) == 0) std::ranges::fill(part.inner, 0);
  }
  for (std::size_t i = 0; i < solid.parts.size(); ++i) look_beyond(solid.parts, i, kSlack * size);
  return solid;
}

SolidParts solid_parts(const Shape& shape, Side felt_from) {
  const bool hollow = felt_from == Side::inside;
  if (std::holds_alternative<Plane>(shape)) return half_space(hollow);
  on_primitive(
      shape,
      [](const auto& solid) {
        if (!solid.kConvex)
          throw std::invalid_argument(
              std::string("a ") + solid.kName +
              " is not convex; give it as a closed mesh, or take a tool of points");
      },
      [] {});
  if (std::holds_alternative<Grid>(shape))
    throw std::invalid_argument(
        "a grid of distances has no polygons; give the mesh itself, or take a tool of points");
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    const TriangleMesh& triangles = mesh->surface->mesh();
    if (!triangles.report().closed() || !(triangles.report().volume > 0.0))
      throw std::invalid_argument("its mesh is not closed, so it has no inside; " +
                                  mend_text(triangles.report()) + ", or take a tool of points");
    if (!is_convex_mesh(triangles))
      throw std::invalid_argument(
          hollow ? "a hollow that is not convex cannot be felt from inside by a tool of polygons; "
                   "give the solid round it as a mesh, or take a tool of points"
                 : "its mesh is not convex; give it convex parts");
    std::vector<Vec3> corners = triangles.vertices();
    for (Vec3& corner : corners) corner += triangles.origin();
    return one_part(corners, hollow);
  }
  for (int segments = kRoundSegments;; segments /= 2) {
    const TriangleSoup surface = tessellate(shape, segments);
    if (surface.vertices.size() <= kMostPolyhedronVertices || segments <= 8)
      return one_part(surface.vertices, hollow);
  }
}

}  // namespace feltwire
