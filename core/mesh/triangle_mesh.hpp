#pragma once
// A surface of triangles: what a mesh file holds, made fit to be touched.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/triangle_soup.hpp"

namespace feltwire {

/// The corner of a triangle that follows, round it: 0, 1, 2, 0.
constexpr std::size_t corner_after(std::size_t corner) { return corner == 2 ? 0 : corner + 1; }

/// What was found while a soup became a mesh. Nothing here is an error: a mesh of any of these can
/// be touched.
struct MeshReport {
  std::size_t welded = 0;              // vertices at exactly the place of another: now one
  std::size_t joined = 0;              // vertices of open edges close to another: now one
  double weld = 0.0;                   // [m] they were at most that far apart,
  double joined_farthest = 0.0;        // [m] and in fact that far
  std::size_t degenerate = 0;          // triangles without an area: left out
  double degenerate_height = 0.0;      // [m] of the highest of them
  std::size_t duplicate = 0;           // triangles on the corners of an earlier one: left out
  std::size_t boundary_edges = 0;      // with one triangle
  std::size_t non_manifold_edges = 0;  // with more than two
  std::size_t turned_edges = 0;        // whose two triangles disagree about the outside
  std::size_t most_at_corner = 0;      // triangles round one corner
  std::size_t holes = 0;               // rings of edges with one triangle
  double narrowest_hole = 0.0;         // [m] across
  double widest_hole = 0.0;            // [m] across
  double volume = 0.0;                 // [m^3] enclosed; < 0 where the normals look inwards
  double size = 0.0;                   // [m] the longest side of the box about it
  double typical_side = 0.0;           // [m] of the triangles' longest sides the middle one

  /// Every edge has two triangles that agree about the outside.
  bool closed() const {
    return boundary_edges == 0 && non_manifold_edges == 0 && turned_edges == 0;
  }
};

/// Triangles with their neighbours. Immutable; coordinates are relative to `origin`, the middle of
/// the surface, so that they have all digits wherever it lies.
class TriangleMesh {
 public:
  /// No triangle beyond an edge that the surface crosses smoothly: the edge has one triangle, more
  /// than two, or two that disagree about the outside.
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  /// Of the longest side of the box about a surface: ends of open edges closer than this are
  /// joined. Below what six decimals of a coordinate tell apart.
  static constexpr double kWeld = 1e-6;

  TriangleMesh() = default;
  /// Welds equal vertices and ends of open edges that are at most `weld` [m] apart (kWeld of the
  /// size where it is not given; 0: none), leaves out degenerate triangles (no height above the
  /// rounding of their own corners: a relative measure, no size is too small) and duplicates, finds
  /// the neighbours.
  /// Throws std::invalid_argument for an index that has no vertex, a coordinate that is not finite,
  /// more than 2^30 triangles, or when no triangle is left.
  explicit TriangleMesh(const TriangleSoup& soup, std::optional<double> weld = {});

  const Vec3& origin() const { return origin_; }  // [m]
  /// [m] half the size of the bounding box, whose middle is the origin.
  const Vec3& half_extents() const { return half_extents_; }
  const std::vector<Vec3>& vertices() const { return vertices_; }  // [m] from the origin
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// Beyond edge k (from corner k to corner k + 1) of triangle t.
  std::uint32_t neighbour(std::uint32_t t, int k) const {
    return neighbours_[t][static_cast<std::size_t>(k)];
  }
  /// Triangles round a vertex, in ascending order.
  std::span<const std::uint32_t> around(std::uint32_t vertex) const {
    return std::span(around_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }
  const MeshReport& report() const { return report_; }
  std::array<Vec3, 3> corners(std::uint32_t t) const {
    const Triangle& c = triangles_[t];
    return {vertices_[c[0]], vertices_[c[1]], vertices_[c[2]]};
  }
  std::size_t memory() const;  // [bytes]

  /// The same surface with its outside turned in.
  void turn();

 private:
  void weld(const TriangleSoup& soup);
  void index_vertices();
  void drop_duplicates();
  std::vector<std::array<std::uint32_t, 2>> find_neighbours();
  std::vector<std::array<std::uint32_t, 2>> join_open_edges(
      std::vector<std::array<std::uint32_t, 2>> open);
  bool keep_areas();
  double volume() const;
  double typical_side() const;

  Vec3 origin_ = Vec3::Zero(), half_extents_ = Vec3::Zero();
  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<Triangle> neighbours_;
  std::vector<std::uint32_t> first_, around_;  // of vertex v: around_[first_[v]] ...
  MeshReport report_;
};

/// What a person should know of it, one line a finding, with the remedy; none for a clean closed
/// surface. `closed`: whether it is meant to bound a solid.
std::vector<std::string> warnings(const MeshReport& report, bool closed);

/// ", 2 holes 1e-05 m to 0.02 m across", empty where there is none.
std::string holes_text(const MeshReport& report);

/// Unit normal of a triangle, right for every size; zero for a degenerate one.
Vec3 triangle_normal(const std::array<Vec3, 3>& corners) noexcept;

}  // namespace feltwire
