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
  double slack = 0.0;                            // [m] that facets stand off what they are cut from
  double distance = 0.0;                         // [m]
  std::uint32_t triangle = TriangleMesh::kNone;  // that it was fitted to

  /// From the point, less what is along the axis.
  Vec3 way(const Vec3& p) const {
    const Vec3 d = p - point;
    return d - axis.dot(d) * axis;
  }
  /// As height_above() (local_contact.hpp), but for the root, which is near one where this is
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
  /// As SurfacePatch has it.
  bool joined() const { return joined_; }
  void set_joined(bool joined) { joined_ = joined; }
  /// Precondition: fewer than kMaxPatches.
  void add(const MeshFit& fit) { fits_[static_cast<std::size_t>(count_++)] = fit; }
  /// One plane more, if they meet in convex edges all or in hollow ones all; else false.
  bool join(const MeshFit& plane);

  /// Where a triangle begins that the patches do not describe.
  struct Other {
    double distance = 0.0;  // [m] from the place
    std::uint32_t triangle =
        TriangleMesh::kNone;  // kNone: the border of the surface, or of what was looked at
    double looked = 0.0;      // [m] how far along the surface was looked
    bool border = false;      // the surface ends
  };
  /// The nearest of a place `height` [m] off the surface, over an extent [m] of it; less where
  /// there are too many triangles.
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
