#include "core/local_model_extraction/fitted_patches.hpp"

#include <algorithm>

namespace feltwire {

FittedPatches fitted_patches(const Object& object, const Vec3& position,
                             const FeatureMemory& memory, double ball, bool whole) noexcept {
  if (const auto* mesh = std::get_if<Mesh>(&object.shape))
    return (whole ? mesh_mark : mesh_patches)(*mesh->surface, object.felt_from, position, memory,
                                              ball);
  if (const auto* grid = std::get_if<Grid>(&object.shape))
    return grid_patches(*grid, object.felt_from, position, ball);
  return {};
}

double fitted_radius(const Object& object, const FittedPatches& fitted, int count, int index,
                     double ball) noexcept {
  if (fitted.whole) return 0.0;
  if (const auto* mesh = std::get_if<Mesh>(&object.shape))
    return mesh_patch_radius(*mesh->surface, fitted, count, index, ball);
  return std::max(0.0, fitted.extent - ball);
}

}  // namespace feltwire
