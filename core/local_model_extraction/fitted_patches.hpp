#pragma once
// Surfaces that no patch describes exactly, meshes and grids, as few patches near a point: each
// with how far it holds.

#include <array>
#include <cstdint>
#include <limits>

#include "core/contact/contact.hpp"
#include "core/geometry/bend.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// [m] Nothing is fitted farther away: no model reaches there (near.hpp).
inline constexpr double kMostFitted = 0.1;

/// As a SurfacePatch, in the object's frame.
struct FittedPatch {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ(), axis = Vec3::Zero();
  double curvature = 0.0;
  double distance = 0.0;  // [m] from the position, where it begins to count
  double slack = 0.0;     // [m] beside kPatchSlope: what facets stand off what they are cut from
  std::uint32_t feature = 0;
};

struct FittedPatches {
  std::array<FittedPatch, kMaxPatches> patches{};  // nearest first
  int count = 0;
  bool joined = false;                                   // as SurfacePatch has it
  double end = std::numeric_limits<double>::infinity();  // [m] from the position: from here on
                                                         // there is what they do not describe
  double extent = 0.0;  // [m] about their points: beyond, nothing was looked at
  bool alone = false;   // within that extent nothing but this one patch was found
  double offset = 0.0;  // [m] these, too, as SurfacePatch has them
  bool faceted = false, rough = false;
};

inline bool is_fitted(const Shape& shape) noexcept {
  return std::holds_alternative<Mesh>(shape) || std::holds_alternative<Grid>(shape);
}

/// A mesh or a grid near a position [m, object frame]. `memory` as contact left it there.
FittedPatches fitted_patches(const Object& object, const Vec3& position,
                             const FeatureMemory& memory) noexcept;

/// [m] about a patch's point: beyond, what the first `count` patches do not describe may begin.
double fitted_radius(const Object& object, const FittedPatches& fitted, int count,
                     int index) noexcept;

FittedPatches mesh_patches(const MeshSurface& surface, Side felt_from, const Vec3& position,
                           const FeatureMemory& memory) noexcept;
double mesh_patch_radius(const MeshSurface& surface, const FittedPatches& fitted, int count,
                         int index) noexcept;
FittedPatches grid_patches(const Grid& grid, Side felt_from, const Vec3& position) noexcept;

}  // namespace feltwire
