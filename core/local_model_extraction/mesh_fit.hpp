#pragma once
// The patches that stand for a mesh near a position, and the distance up to which they do.
//
// Every triangle near is checked: it lies on a patch and is not cut off by another, or it is hidden
// behind them, or the patches hold only up to where it begins.

#include <array>
#include <cstdint>

#include "core/local_model/local_model.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// Cosine between a triangle's normal and that of the patch it lies on, at least.
inline constexpr double kFacing = 0.5;

/// A patch, from the mesh's origin.
struct MeshFit {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  double slack = 0.0;                            // [m] that facets are off the true surface
  double distance = 0.0;                         // [m]
  std::uint32_t triangle = TriangleMesh::kNone;  // that it was fitted to

  /// The vector from the patch's point to p, without its part along the axis.
  Vec3 way(const Vec3& p) const {
    const Vec3 d = p - point;
    return d - axis.dot(d) * axis;
  }
  /// [m] height_above() (local_contact.hpp) without its root, which is near one where the height is
  /// small.
  double height(const Vec3& p) const {
    const Vec3 d = way(p);
    return normal.dot(d) + 0.5 * curvature * d.squaredNorm();
  }
};

/// The patches together; the surface is felt from the side that their normals point to.
class MeshFits {
 public:
  /// `side`: 1 where the triangles' normals point to the open, -1 where they point away from it.
  MeshFits(const MeshSurface& surface, double side) : surface_(&surface), side_(side) {}

  int count() const { return count_; }
  const MeshFit& operator[](int i) const { return fits_[static_cast<std::size_t>(i)]; }
  /// As SurfacePatch::joined.
  bool joined() const { return joined_; }
  void set_joined(bool joined) { joined_ = joined; }
  /// Precondition: fewer than kMaxPatches.
  void add(const MeshFit& fit) { fits_[static_cast<std::size_t>(count_++)] = fit; }
  /// Adds a plane if all edges between the patches are then convex, or all are hollow. Else it adds
  /// nothing and returns false.
  bool join(const MeshFit& plane);

  /// Where something begins that the patches do not describe.
  struct Other {
    double distance = 0.0;  // [m] from the place
    std::uint32_t triangle =
        TriangleMesh::kNone;  // kNone: the border of the surface, or of the part searched
    double looked = 0.0;      // [m] along the surface that was searched
    bool border = false;      // the surface ends
  };
  /// The nearest such beginning to a place `height` [m] off the surface. Searches the surface
  /// within `extent` [m], or less where there are too many triangles.
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
