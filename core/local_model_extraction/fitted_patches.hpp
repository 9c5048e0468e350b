#pragma once
// Meshes and grids near a point as a few patches, each with the distance up to which it holds. No
// patch describes these surfaces exactly.

#include <array>
#include <cstdint>
#include <limits>

#include "core/contact/contact.hpp"
#include "core/geometry/bend.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// [m] Nothing is fitted farther away: no model reaches there (kModelReach, extract.hpp).
inline constexpr double kMostFitted = 0.1;

/// A SurfacePatch in the object's frame.
struct FittedPatch {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  double distance = 0.0;  // [m] from the position, where it begins to count
  double slack = 0.0;     // [m] beside kPatchSlope: how far facets are off the true surface
  std::uint32_t feature = 0;
};

struct FittedPatches {
  std::array<FittedPatch, kMaxPatches> patches{};  // nearest first
  int count = 0;
  bool joined = false;                                   // as SurfacePatch has it
  double end = std::numeric_limits<double>::infinity();  // [m] from the position: here begins
                                                         // something that they do not describe
  double extent = 0.0;  // [m] about their points, that was searched
  bool alone = false;   // within that extent there is nothing but this one patch
  double offset = 0.0;  // [m] as SurfacePatch has it, and so the next two
  bool faceted = false, rough = false;
};

inline bool is_fitted(const Shape& shape) noexcept {
  return std::holds_alternative<Mesh>(shape) || std::holds_alternative<Grid>(shape);
}

/// The patches of a mesh or a grid near a position [m, object frame]. `memory` is that of the
/// contact at this position.
FittedPatches fitted_patches(const Object& object, const Vec3& position,
                             const FeatureMemory& memory) noexcept;

/// [m] about the point of patch `index`. Only beyond this radius may a surface begin that the first
/// `count` patches do not describe.
double fitted_radius(const Object& object, const FittedPatches& fitted, int count,
                     int index) noexcept;

FittedPatches mesh_patches(const MeshSurface& surface, Side felt_from, const Vec3& position,
                           const FeatureMemory& memory) noexcept;
double mesh_patch_radius(const MeshSurface& surface, const FittedPatches& fitted, int count,
                         int index) noexcept;
FittedPatches grid_patches(const Grid& grid, Side felt_from, const Vec3& position) noexcept;

}  // namespace feltwire
