#pragma once
// Approximates meshes and grids near a point by a few patches, each with the distance up to which
// it is valid. No patch describes these surfaces exactly.

#include <array>
#include <cstdint>
#include <limits>

#include "core/contact/contact.hpp"
#include "core/geometry/local_curvature.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// [m] Nothing is fitted farther away: no model reaches there (kModelReach, extract.hpp).
inline constexpr double kMostFitted = 0.1;

/// A SurfacePatch in the object's frame.
struct FittedPatch {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  double distance = 0.0;  // [m] from the position; the patch counts from here on
  double slack =
      0.0;  // [m] in addition to kPatchSlope: error of the facets against the true surface
  std::uint32_t feature = 0;
};

struct FittedPatches {
  std::array<FittedPatch, kMaxPatches> patches{};  // nearest first
  int count = 0;
  bool joined = false;                                   // as in SurfacePatch
  double end = std::numeric_limits<double>::infinity();  // [m] from the position to the first
                                                         // surface that the patches do not describe
  double extent = 0.0;                                   // [m] searched distance about their points
  bool alone = false;   // within that extent there is only this patch
  double offset = 0.0;  // [m] as in SurfacePatch, and so the next two
  bool faceted = false, rough = false;
  bool whole = false;  // as in SurfacePatch: the one patch is a mark on the whole surface
};

inline bool is_fitted(const Shape& shape) noexcept {
  return std::holds_alternative<Mesh>(shape) || std::holds_alternative<Grid>(shape);
}

/// The patches of a mesh or a grid near a position [m, object frame]. `memory` is that of the
/// contact at this position. `ball` [m]: the radius of the tool; 0: a point. `whole`: the receiver
/// has the whole surface, which is a mesh.
FittedPatches fitted_patches(const Object& object, const Vec3& position,
                             const FeatureMemory& memory, double ball, bool whole) noexcept;

/// [m] about the point of patch `index`. A surface that the first `count` patches do not describe
/// may begin only beyond this radius. `ball`: as above.
double fitted_radius(const Object& object, const FittedPatches& fitted, int count, int index,
                     double ball) noexcept;

FittedPatches mesh_patches(const MeshSurface& surface, Side felt_from, const Vec3& position,
                           const FeatureMemory& memory, double ball) noexcept;
/// The mark on a mesh that the receiver has in full. None if the tool is farther away than
/// kMostFitted.
FittedPatches mesh_mark(const MeshSurface& surface, Side felt_from, const Vec3& position,
                        const FeatureMemory& memory, double ball) noexcept;
double mesh_patch_radius(const MeshSurface& surface, const FittedPatches& fitted, int count,
                         int index, double ball) noexcept;
FittedPatches grid_patches(const Grid& grid, Side felt_from, const Vec3& position,
                           double ball) noexcept;

/// Whether a ball [m] rolls on a surface so curved [1/m] as on the patch that was fitted to it. In
/// a hollow of less than twice its radius it magnifies what a fit errs by.
inline bool rolls(double ball, double curvature) noexcept {
  constexpr double kMostHollow = 0.5;
  return ball * curvature > -kMostHollow;
}

}  // namespace feltwire
