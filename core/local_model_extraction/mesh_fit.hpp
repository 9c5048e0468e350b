#pragma once
// Approximates a mesh near a position by patches, and finds the distance up to which they are
// valid.
//
// Every near triangle is checked: it lies on a patch that no other cuts off, or it is hidden behind
// the patches, or they are valid only up to its beginning.

#include <array>
#include <cstdint>

#include "core/local_model/local_model.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// Smallest cosine between a triangle's normal and that of its patch.
inline constexpr double kFacing = 0.5;

/// A patch, from the mesh's origin.
struct MeshFit {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  double slack = 0.0;                            // [m] error of the facets against the true surface
  double distance = 0.0;                         // [m]
  std::uint32_t triangle = TriangleMesh::kNone;  // the triangle that it was fitted to

  /// The vector from the patch's point to p, without its part along the axis.
  Vec3 way(const Vec3& p) const {
    const Vec3 d = p - point;
    return d - axis.dot(d) * axis;
  }
  /// [m] The same as height_above() (local_contact.hpp) without its root, which is near one for a
  /// small height.
  double height(const Vec3& p) const {
    const Vec3 d = way(p);
    return normal.dot(d) + 0.5 * curvature * d.squaredNorm();
  }
};

/// All patches; the surface is felt from the side of their normals.
class MeshFits {
 public:
  /// `side`: 1 if the triangles' normals point to the open side, -1 if they point away from it.
  MeshFits(const MeshSurface& surface, double side) : surface_(&surface), side_(side) {}

  int count() const { return count_; }
  const MeshFit& operator[](int i) const { return fits_[static_cast<std::size_t>(i)]; }
  /// As SurfacePatch::joined.
  bool joined() const { return joined_; }
  void set_joined(bool joined) { joined_ = joined; }
  /// Precondition: fewer than kMaxPatches.
  void add(const MeshFit& fit) { fits_[static_cast<std::size_t>(count_++)] = fit; }
  /// Adds a plane if all edges between the patches are then convex, or all are hollow. Otherwise it
  /// adds nothing and returns false.
  bool join(const MeshFit& plane);

  /// The beginning of a part that the patches do not describe.
  struct Other {
    double distance = 0.0;  // [m] from the place
    std::uint32_t triangle =
        TriangleMesh::kNone;  // kNone: the border of the surface, or of the searched part
    double looked = 0.0;      // [m] along the surface that was searched
    bool border = false;      // the surface ends
  };
  /// Returns the nearest such beginning to a place `height` [m] off the surface. It searches the
  /// surface within `extent` [m], or less if there are too many triangles.
  Other first_other(const Vec3& place, double height, double extent) const;

 private:
  Other beginning(std::uint32_t t, const Vec3& place) const;
  double border(std::uint32_t t, const std::array<Vec3, 3>& corners, const Vec3& place) const;
  std::array<Vec3, 3> corners(std::uint32_t t) const { return surface_->mesh().corners(t); }
  bool faces(const MeshFit& fit, const std::array<Vec3, 3>& corners) const;

  const MeshSurface* surface_;
  double side_;
  std::array<MeshFit, kMaxPatches> fits_{};
  int count_ = 0;
  bool joined_ = false;
};

}  // namespace feltwire
