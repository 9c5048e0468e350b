#pragma once
// A triangle mesh with its tree: the questions that contact asks of it. All coordinates are
// relative to the mesh's origin.

#include <memory>
#include <optional>

#include "core/mesh/box_tree.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

class HeightMap;

/// Roughness: the surface is waves of this length, cut into it, in directions all ways.
struct Grain {
  double amplitude = 0.0;   // [m] about the mean; 0: smooth
  double wavelength = 1.0;  // [m]
};

struct MeshOptions {
  bool double_sided = false;  // felt from both sides, whatever the normals say
  bool smooth = false;        // the force's direction from normals interpolated between corners
  double radius = 0.0;        // [m] of the ball that touches; 0: a point
  Grain grain = {};
  std::shared_ptr<const HeightMap> height_map = {};  // null: none

  bool rough() const { return grain.amplitude > 0.0 || height_map != nullptr; }
};

/// The point of a triangle that is nearest to p, and its weights on the corners.
struct NearestOnTriangle {
  Vec3 point = Vec3::Zero();
  Vec3 weights = Vec3::Zero();  // >= 0, sum 1; zero where the point lies on an edge or a corner
  // What it lies on: 0 the face, 1 + k edge k (from corner k to corner k + 1), 4 + k corner k.
  std::size_t part = 0;
};
NearestOnTriangle nearest_on_triangle(const std::array<Vec3, 3>& corners, const Vec3& p) noexcept;

/// Where a movement first goes through a triangle.
struct Crossing {
  double part = 0.0;  // of the movement, 0 to 1
  std::uint32_t triangle = 0;
  std::int8_t side = 1;  // from which it came: 1 where the normal points
};

class MeshSurface {
 public:
  /// Throws as TriangleMesh does, and std::runtime_error where there is no memory for the tree.
  explicit MeshSurface(TriangleMesh mesh, const MeshOptions& options = {});

  const TriangleMesh& mesh() const { return mesh_; }
  const BoxTree& tree() const { return tree_; }
  const MeshOptions& options() const { return options_; }
  /// [m] What a proxy stands off where it is held by triangles that do not know each other: below
  /// what coordinates in single precision can tell apart at this size.
  double skin() const { return skin_; }

  /// The flat face that a triangle is part of, as the lowest index of its triangles: those that
  /// neighbours join and whose normals differ by no more than rounding from that one's.
  std::uint32_t face(std::uint32_t t) const { return faces_[t]; }

  /// Normals at the corners, unit, weighted by the angles round them; only of smooth surfaces.
  const std::vector<Vec3>& normals() const { return normals_; }
  /// That normal at one corner, of any surface.
  Vec3 normal_at(std::uint32_t vertex) const noexcept {
    return normals_.empty() ? corner_normal(vertex) : normals_[vertex];
  }

  /// Does this movement go through triangle t, from a side of `sides`? `part` says where. In the
  /// plane is in front of one side; of both sides, it is reached, and no way begins there. Of two
  /// triangles with a common edge no movement passes between, nor of two edges without a neighbour
  /// that are at most two skins apart: such an edge reaches a skin farther than it is.
  std::optional<Crossing> crossing(std::uint32_t t, const Vec3& from, const Vec3& to,
                                   std::int8_t sides) const noexcept;
  /// The first of all; of equal ones that of the lowest index. sides: 1, -1, or 0 for both.
  std::optional<Crossing> first_crossing(const Vec3& from, const Vec3& to,
                                         std::int8_t sides) const noexcept;

  struct NearestTriangle {
    std::uint32_t triangle = 0;
    Vec3 point = Vec3::Zero();
    Vec3 weights = Vec3::Zero();
    double distance = std::numeric_limits<double>::infinity();  // [m]
  };
  /// The nearest within `most` [m]; its distance is infinite when there is none.
  NearestTriangle nearest(const Vec3& p, double most) const noexcept;
  /// On which side of the surface a point lies whose nearest point is this: > 0 outside, by the
  /// normal of face, edge or corner, the last weighted by angle (Baerentzen & Aanaes 2005).
  double side_of(const Vec3& p, const NearestTriangle& nearest) const noexcept;

  std::size_t memory() const;  // [bytes]

 private:
  Vec3 corner_normal(std::uint32_t vertex) const noexcept;

  TriangleMesh mesh_;
  MeshOptions options_;
  double skin_ = 0.0;
  BoxTree tree_;
  std::vector<Vec3> normals_;
  std::vector<std::uint32_t> faces_;
};

}  // namespace feltwire
