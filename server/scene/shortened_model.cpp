#include "server/scene/shortened_model.hpp"

#include <algorithm>

namespace feltwire {
namespace {

// [bytes] Size of a patch and of a body point in a datagram.
constexpr std::size_t kPatchBytes = 96, kBodyPointBytes = 36;

/// Returns the distance [m] from `center` to the surface of the patch; 0 if the tool touches it.
double way_to(const SurfacePatch& patch, const Vec3& center) {
  return patch.touching ? 0.0 : std::max(0.0, (center - patch.point).norm() - patch.offset);
}

/// Returns the number of parts of `size` [bytes] to remove, so that `excess` [bytes] are saved.
int parts_of(std::size_t excess, std::size_t size) {
  return static_cast<int>((excess + size - 1) / size);
}

}  // namespace

void shorten(LocalModel& model, std::size_t excess) noexcept {
  for (int count = parts_of(excess, kPatchBytes); count > 0 && model.count > 0; --count) {
    --model.count;
    const SurfacePatch& dropped = model.patches[static_cast<std::size_t>(model.count)];
    model.reach = std::min(model.reach, way_to(dropped, model.center));
  }
  if (!(model.reach > 0.0)) model.count = 0;
}

int shortened_points(const BodyModel& model, std::size_t excess) noexcept {
  return model.count - parts_of(excess, kBodyPointBytes);
}

}  // namespace feltwire
