#pragma once
// The proxy of a tool on the patches of one object.

#include <cstdint>

#include "core/base/types.hpp"
#include "core/geometry/shapes.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// The proxy, and the patch it lies on.
struct PatchProxy {
  const SurfacePatch* patch =
      nullptr;           // the deepest, or the one by which the tool entered; null: free
  SurfacePoint surface;  // [world] depth > 0 unless free
};

/// An earlier position of the tool. With it the proxy does not jump over a thin solid.
struct CameFrom {
  bool known = false;
  Vec3 position = Vec3::Zero();  // [m, world]
  double elapsed = 0.0;          // [s] since
};

/// The proxy of a tool [m, world] on an object's patches, `age` [s] after the state that the model
/// describes. Of `before` it uses the feature (the face by which the tool entered), the proxy [m,
/// world, moved on to now] and the normal, which is needed where the geometry leaves it undefined.
/// The returned patch is one of the model's.
PatchProxy patch_proxy(const LocalModel& model, std::uint16_t object, const Vec3& tool, double age,
                       const FeatureMemory& before, const CameFrom& from = {}) noexcept;

}  // namespace feltwire
