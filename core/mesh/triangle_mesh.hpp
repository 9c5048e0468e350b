#pragma once
// A surface of triangles with their neighbours, made from the triangles of a mesh file.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/geometry/triangle_soup.hpp"

namespace feltwire {

/// The next corner round a triangle: 0, 1, 2, 0.
constexpr std::size_t corner_after(std::size_t corner) { return corner == 2 ? 0 : corner + 1; }

/// Open edges with corners of other triangles on them, which were split there.
struct SplitEdges {
  std::size_t count = 0;
  std::size_t added = 0;      // triangles more than before by that
  double farthest = 0.0;      // [m] largest distance of such a corner from its edge
  bool search_ended = false;  // too many open edges lie over each other: not all looked at
};

/// Rings of edges with one triangle: holes, or the border of a sheet.
struct MeshHoles {
  std::size_t count = 0;
  double narrowest = 0.0, widest = 0.0;  // [m] about the size of a ball that passes
};

/// The findings of TriangleMesh's constructor. None is an error: every such mesh can be touched.
struct MeshReport {
  std::size_t joined = 0;          // vertices of open edges close to another, made one
  double weld = 0.0;               // [m] largest distance that is joined
  double joined_farthest = 0.0;    // [m] largest distance that was joined
  std::size_t degenerate = 0;      // triangles without an area: left out
  double degenerate_height = 0.0;  // [m] largest height of these
  SplitEdges split{};
  std::size_t duplicate = 0;           // triangles on the corners of another one: left out
  std::size_t opposed = 0;             // of these: they faced the other way than their neighbours
  std::size_t both_sides = 0;          // faces with a triangle on each side: no neighbour decides
  std::size_t boundary_edges = 0;      // with one triangle
  std::size_t non_manifold_edges = 0;  // with more than two
  std::size_t turned_edges = 0;        // whose two triangles disagree about the outside
  std::size_t most_at_corner = 0;      // triangles round one corner
  MeshHoles holes{};
  double volume = 0.0;        // [m^3] enclosed; < 0 if the normals point inwards
  double size = 0.0;          // [m] the longest side of the box about it
  double typical_side = 0.0;  // [m] median of the triangles' longest sides

  /// Every edge has two triangles that agree about the outside.
  bool closed() const {
    return boundary_edges == 0 && non_manifold_edges == 0 && turned_edges == 0;
  }
};

/// Triangles with their neighbours. Coordinates are relative to `origin`, the middle of the
/// surface, so that they keep all digits wherever the surface lies.
class TriangleMesh {
 public:
  /// Stands for a missing neighbour: the edge has one triangle, more than two, or two that disagree
  /// about the outside.
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  /// Ends of open edges are joined if they are closer than this share of the longest side of the
  /// box about the surface. Six decimals of a coordinate do not tell such ends apart.
  static constexpr double kWeld = 1e-6;

  TriangleMesh() = default;
  /// Joins equal vertices, and ends of open edges that are at most `weld` [m] apart (by default:
  /// kWeld times the size; 0: none). Splits open edges on which such ends lie, at most as far away.
  /// Leaves out duplicate triangles, and degenerate ones, whose height is within the rounding of
  /// their own corners; no size is too small. Of two triangles on the same corners that face away
  /// from each other, the one stays that agrees with its neighbours. If no neighbour decides, both
  /// stay, and the face is felt from both sides. Finds the neighbours.
  ///
  /// `solid`: the surface is meant to bound a solid. A closed shell that no neighbour decides is
  /// then kept with its outside outwards.
  ///
  /// Throws std::invalid_argument for an index without a vertex, a coordinate that is not finite,
  /// more than 2^30 triangles, or if no triangle is left.
  explicit TriangleMesh(const TriangleSoup& soup, std::optional<double> weld = {},
                        bool solid = false);

  const Vec3& origin() const { return origin_; }  // [m]
  /// [m] half the size of the bounding box, whose middle is the origin.
  const Vec3& half_extents() const { return half_extents_; }
  const std::vector<Vec3>& vertices() const { return vertices_; }  // [m] from the origin
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// The triangle beyond edge k (from corner k to corner k + 1) of triangle t, or kNone.
  std::uint32_t neighbour(std::uint32_t t, int k) const {
    return neighbours_[t][static_cast<std::size_t>(k)];
  }
  /// The triangles round a vertex, in ascending order.
  std::span<const std::uint32_t> around(std::uint32_t vertex) const {
    return std::span(around_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }
  /// The triangle on the same corners that faces the other way, or kNone.
  std::uint32_t reverse_of(std::uint32_t t) const;
  const MeshReport& report() const { return report_; }
  std::array<Vec3, 3> corners(std::uint32_t t) const {
    const Triangle& c = triangles_[t];
    return {vertices_[c[0]], vertices_[c[1]], vertices_[c[2]]};
  }
  std::size_t memory() const;  // [bytes]

  /// Turns the outside in: all normals point the other way.
  void turn();

 private:
  /// Edges that one face has, and the sides of its triangles there (3 * triangle + number): two for
  /// a face with a triangle on each side.
  struct OpenEdges {
    std::vector<std::array<std::uint32_t, 2>> edges;
    std::vector<std::uint32_t> sides;
  };

  void weld(const TriangleSoup& soup);
  void index_vertices();
  void drop_duplicates();
  OpenEdges find_neighbours();
  OpenEdges join_open_edges(OpenEdges open);
  OpenEdges split_open_edges(OpenEdges open);
  bool same_corners(std::uint32_t one, std::uint32_t other) const;
  bool keep_areas();
  double volume() const;
  double typical_side() const;

  Vec3 origin_ = Vec3::Zero(), half_extents_ = Vec3::Zero();
  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<Triangle> neighbours_;
  std::vector<std::uint32_t> first_, around_;  // of vertex v: around_[first_[v]] ...
  MeshReport report_;
  bool solid_ = false;
};

/// The findings that a person should know, one line each, with the remedy. Empty for a clean closed
/// surface. `closed`: whether the surface is meant to bound a solid.
std::vector<std::string> warnings(const MeshReport& report, bool closed);

/// ", 2 holes 1e-05 m to 0.02 m across"; empty if there is none.
std::string holes_text(const MeshReport& report);

/// Why a surface bounds no solid: "3 open edges, 1 hole 2e-07 m across, 0 with more than two
/// triangles, 0 between triangles turned against each other". Precondition: !report.closed().
std::string open_text(const MeshReport& report);

/// "mend it", and before it the weld that closes its holes where all of them are narrow: rounded
/// coordinates leave such holes.
std::string mend_text(const MeshReport& report);

/// The unit normal of a triangle of any size; zero for a degenerate one.
Vec3 triangle_normal(const std::array<Vec3, 3>& corners) noexcept;

}  // namespace feltwire
