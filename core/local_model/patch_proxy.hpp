#pragma once
// Where a tool stands on the patches of one object.

#include <cstdint>

#include "core/base/types.hpp"
#include "core/geometry/shapes.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

struct PatchProxy {
  const SurfacePatch* patch = nullptr;  // the deepest, or the one it was entered by; null: free
  SurfacePoint surface;                 // [world] depth > 0 unless free
};

/// Where the tool was a while ago, so that no thin solid is passed by.
struct CameFrom {
  bool known = false;
  Vec3 position = Vec3::Zero();  // [m, world]
  double elapsed = 0.0;          // [s] since
};

/// The proxy of a tool [m, world] on an object's patches, `age` [s] after the state that the model
/// describes. Of `before`, feature, normal and proxy [m, world, by now]: the face it entered by,
/// the edge it was on, and what is used where the geometry leaves the normal undefined. The patch
/// is one of the model's.
PatchProxy patch_proxy(const LocalModel& model, std::uint16_t object, const Vec3& tool, double age,
                       const FeatureMemory& before, const CameFrom& from = {}) noexcept;

}  // namespace feltwire
