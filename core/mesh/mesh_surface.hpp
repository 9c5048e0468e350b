#pragma once
// A triangle mesh with a tree over its triangles, for the queries of contact. All coordinates are
// relative to the mesh's origin.

#include <memory>
#include <optional>

#include "core/mesh/box_tree.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

class HeightMap;

/// Roughness: waves of one length, in many directions, are cut into the surface.
struct Grain {
  double amplitude = 0.0;   // [m] about the mean; 0: smooth
  double wavelength = 1.0;  // [m]
};

struct MeshOptions {
  bool double_sided = false;  // felt from both sides; the normals do not matter
  bool smooth = false;        // the force has the direction of normals interpolated between corners
  double radius = 0.0;        // [m] of the ball that touches; 0: a point
  Grain grain = {};
  std::shared_ptr<const HeightMap> height_map = {};  // null: none

  bool rough() const { return grain.amplitude > 0.0 || height_map != nullptr; }
};

/// The point of a triangle that is nearest to p, and its weights on the corners.
struct NearestOnTriangle {
  Vec3 point = Vec3::Zero();
  Vec3 weights = Vec3::Zero();  // >= 0, sum 1; zero where the point lies on an edge or a corner
  // The part of the triangle: 0 is the face, 1 + k on edge k (from corner k to corner k + 1), 4 + k
  // on corner k.
  std::size_t part = 0;
};
NearestOnTriangle nearest_on_triangle(const std::array<Vec3, 3>& corners, const Vec3& p) noexcept;

/// The place at which a movement passes through a triangle.
struct Crossing {
  double part = 0.0;  // of the movement, 0 to 1
  std::uint32_t triangle = 0;
  std::int8_t side = 1;  // where the movement began: 1 where the normal points, -1 behind
};

class MeshSurface {
 public:
  /// Throws as BoxTree does.
  explicit MeshSurface(TriangleMesh mesh, const MeshOptions& options = {});

  const TriangleMesh& mesh() const { return mesh_; }
  const BoxTree& tree() const { return tree_; }
  const MeshOptions& options() const { return options_; }
  /// [m] The distance that a proxy keeps from triangles that are not neighbours of each other. It
  /// is less than single-precision coordinates can tell apart at this size.
  double skin() const { return skin_; }

  /// The flat face that a triangle is part of, as the lowest index of the face's triangles. A face
  /// is made of neighbours whose normals are that of its first triangle, to rounding.
  std::uint32_t face(std::uint32_t t) const { return faces_[t]; }

  /// Unit normals at the vertices, weighted by the angles round them. Empty unless smooth.
  const std::vector<Vec3>& normals() const { return normals_; }
  /// The unit normal at a vertex of any surface.
  Vec3 normal_at(std::uint32_t vertex) const noexcept {
    return normals_.empty() ? corner_normal(vertex) : normals_[vertex];
  }

  /// The place at which the movement passes through triangle t from a side of `sides`, if it does.
  /// With one side, a point in the triangle's plane is in front of it. With both sides, a point in
  /// the plane has reached the triangle, and no movement begins there. No movement passes between
  /// two triangles with a common edge. An edge without a neighbour reaches one skin farther, so no
  /// movement passes between two such edges that are at most two skins apart.
  std::optional<Crossing> crossing(std::uint32_t t, const Vec3& from, const Vec3& to,
                                   std::int8_t sides) const noexcept;
  /// The first crossing of any triangle; of equal ones, that of the lowest index. sides: 1, -1, or
  /// 0 for both.
  std::optional<Crossing> first_crossing(const Vec3& from, const Vec3& to, std::int8_t sides,
                                         WorkLimit* work = nullptr) const noexcept;

  struct NearestTriangle {
    std::uint32_t triangle = 0;
    Vec3 point = Vec3::Zero();
    Vec3 weights = Vec3::Zero();
    double distance = std::numeric_limits<double>::infinity();  // [m]
  };
  /// The nearest triangle within `most` [m]. Its distance is infinite if there is none. Of equal
  /// ones, that of the lowest index.
  NearestTriangle nearest(const Vec3& p, double most, WorkLimit* work = nullptr) const noexcept;
  /// The side of the surface that p lies on, if `nearest` is its nearest point: > 0 outside. The
  /// sign is that of the angle-weighted pseudo-normal of the face, edge or corner (Baerentzen &
  /// Aanaes, Signed distance computation using the angle weighted pseudonormal, TVCG 2005).
  double side_of(const Vec3& p, const NearestTriangle& nearest,
                 WorkLimit* work = nullptr) const noexcept;

  std::size_t memory() const;  // [bytes]

 private:
  Vec3 corner_normal(std::uint32_t vertex, WorkLimit* work = nullptr) const noexcept;

  TriangleMesh mesh_;
  MeshOptions options_;
  double skin_ = 0.0;
  BoxTree tree_;
  std::vector<Vec3> normals_;
  std::vector<std::uint32_t> faces_;
};

}  // namespace feltwire
