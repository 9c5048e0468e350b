#include "core/local_model_extraction/extract.hpp"

#include <algorithm>
#include <limits>

#include "core/local_model_extraction/patches.hpp"
#include "core/local_model_extraction/prefetched_tool_data.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"

namespace feltwire {
namespace {

constexpr double kLeastTrust = 1e-6;  // least share of a stiffness; a smaller share cannot be felt
constexpr std::size_t kMostObjects = std::numeric_limits<std::uint16_t>::max();

/// A part of an object's surface near the tool.
struct NearbySurface {
  double distance = 0.0;  // [m] distance from the tool
  std::size_t object = 0;
  std::uint32_t feature = 0;
};

/// The nearest parts so far, sorted by distance. Parts at equal distances keep the order of
/// insertion.
class NearestSurfaces {
 public:
  explicit NearestSurfaces(double reach) : reach_(reach) {}
  /// Inserts a part. A part that does not fit or cannot be modelled limits reach_, the distance
  /// within which the model is complete.
  void offer(const NearbySurface& part, bool shown) noexcept {
    if (part.distance >= reach_) return;
    if (!shown) {
      reach_ = part.distance;
      return;
    }
    if (count_ == kMaxPatches) {
      const bool last = part.distance >= parts_[kMaxPatches - 1].distance;
      reach_ = last ? part.distance : parts_[kMaxPatches - 1].distance;
      if (last) return;
      --count_;
    }
    int place = count_++;
    for (; place > 0 && parts_[at(place - 1)].distance > part.distance; --place)
      parts_[at(place)] = parts_[at(place - 1)];
    parts_[at(place)] = part;
  }
  double reach() const { return std::max(0.0, reach_); }
  std::span<const NearbySurface> within_reach() const {
    int count = count_;
    while (count > 0 && parts_[at(count - 1)].distance >= reach_) --count;
    return {parts_.data(), at(count)};
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  std::array<NearbySurface, kMaxPatches> parts_{};
  int count_ = 0;
  double reach_;  // [m] Within this distance, the model is complete.
};

SurfaceParts parts_near(const Object& object, const Vec3& position, std::uint32_t entered,
                        double ball) {
  const Vec3 p = object.pose.orientation.conjugate() * (position - object.pose.position);
  return surface_parts(object.shape, object.felt_from, p, entered, ball);
}

/// Caches the patches that were last fitted to meshes and grids, because the chosen patches are
/// needed again.
class Fitted {
 public:
  Fitted(const KnownSurfaces& known, double ball) : known_(known), ball_(ball) {}
  const FittedPatches& of(const std::vector<Object>& objects, std::size_t object,
                          const Vec3& position, const TouchMemory& memory) noexcept {
    for (const Slot& slot : slots_)
      if (slot.used && slot.object == object) return slot.patches;
    Slot& slot = slots_[next_++ % slots_.size()];
    const Pose& pose = objects[object].pose;
    slot = {
        fitted_patches(objects[object], pose.orientation.conjugate() * (position - pose.position),
                       memory[object].feature, ball_, object < known_.size() && known_[object]),
        object, true};
    return slot.patches;
  }

 private:
  struct Slot {
    FittedPatches patches;
    std::size_t object = 0;
    bool used = false;
  };
  const KnownSurfaces& known_;
  double ball_;  // [m] radius of the tool's ball
  std::array<Slot, kMaxPatches> slots_{};
  std::size_t next_ = 0;
};

/// Returns the chosen patch of a mesh or a grid. Sets the radius within which the patch is valid.
SurfacePatch fitted_patch(const Object& object, const FittedPatches& fitted,
                          const NearbySurface& chosen, std::span<const NearbySurface> all,
                          const ContactMemory& memory, double ball) {
  const auto of_object = [&](const NearbySurface& near) { return near.object == chosen.object; };
  const auto count = static_cast<int>(std::ranges::count_if(all, of_object));
  int index = 0;
  while (index + 1 < fitted.count &&
         fitted.patches[static_cast<std::size_t>(index)].feature != chosen.feature)
    ++index;
  SurfacePatch patch = surface_patch(object, fitted, index, memory);
  patch.radius = std::min(kModelReach, fitted_radius(object, fitted, count, index, ball));
  return patch;
}

/// Returns the distance [m] from a patch's point to the nearest part of the same object that the
/// model lacks.
double radius_of(const Object& object, const SurfacePatch& patch, std::size_t index,
                 std::span<const NearbySurface> chosen, double ball) {
  double radius = kModelReach;
  const SurfaceParts parts = parts_near(object, patch.point + patch.offset * patch.normal, 0, ball);
  for (const SurfacePart& part : parts.view()) {
    const bool described =
        part.shown && std::ranges::any_of(chosen, [&](const NearbySurface& near) {
          return near.object == index && near.feature == part.feature;
        });
    if (!described) radius = std::min(radius, part.distance);
  }
  return radius;
}

/// Marks the face on which the ball lies. On an edge of a solid, the centre of the ball belongs to
/// no face. In this case, the marked face is the face with the normal nearest to the contact
/// normal.
void set_standing(LocalModel& model, const std::vector<Object>& objects,
                  const TouchMemory& memory) {
  const std::span patches{model.patches.data(), static_cast<std::size_t>(model.count)};
  for (SurfacePatch& patch : patches) {
    const Object& object = objects[patch.object];
    const ContactMemory& contact = memory[patch.object];
    if (is_fitted(object.shape) || !contact.touching || contact.feature.feature != 0) continue;
    const Vec3 out = object.pose.orientation * contact.feature.normal;
    const bool faces = std::ranges::none_of(patches, [&](const SurfacePatch& other) {
      return other.object == patch.object && other.normal.dot(out) > patch.normal.dot(out);
    });
    if (faces) set_touched(patch, object, contact);
  }
}

/// Builds the model of a point or a ball. `objects` are the view's objects at their current poses.
LocalModel model_of(const ToolView& view, const std::vector<Object>& objects, const Vec3& position,
                    const TouchMemory& memory, const KnownSurfaces& known) noexcept {
  LocalModel model;
  if (view.tool().body) return model;  // A tool with a body has another model (body_model.hpp).
  const double ball = view.tool().radius;
  if (!position.allFinite() || memory.size() != objects.size()) [[unlikely]]
    return model;
  model.center = position;

  double reach = kModelReach;
  // Guides limit the reach, because a model cannot describe them.
  for (const Guide& guide : view.guides()) reach = std::min(reach, begins(guide, position));
  NearestSurfaces nearest(reach);
  Fitted fits(known, ball);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (is_fitted(objects[i].shape)) {
      const FittedPatches& fitted = fits.of(objects, i, position, memory);
      for (int k = 0; k < fitted.count; ++k) {
        const FittedPatch& patch = fitted.patches[static_cast<std::size_t>(k)];
        nearest.offer({patch.distance, i, patch.feature}, i <= kMostObjects);
      }
      nearest.offer({fitted.end, i, 0}, false);
      continue;
    }
    const SurfaceParts parts = parts_near(objects[i], position, memory[i].feature.feature, ball);
    for (const SurfacePart& part : parts.view())
      nearest.offer({part.distance, i, part.feature}, part.shown && i <= kMostObjects);
  }

  model.reach = nearest.reach();
  const auto chosen = nearest.within_reach();
  for (const NearbySurface& near : chosen) {
    SurfacePatch& patch = model.patches[static_cast<std::size_t>(model.count++)];
    const Object& object = objects[near.object];
    if (is_fitted(object.shape)) {
      patch = fitted_patch(object, fits.of(objects, near.object, position, memory), near, chosen,
                           memory[near.object], ball);
    } else {
      patch = surface_patch(object, position, near.feature, memory[near.object], ball);
      patch.radius = radius_of(object, patch, near.object, chosen, ball);
    }
    patch.object = static_cast<std::uint16_t>(near.object);
  }
  if (ball > 0.0) set_standing(model, objects, memory);
  return model;
}

}  // namespace

bool can_travel(const ToolView& view, std::size_t object) noexcept {
  if (!(object < view.still()) || object > kMostObjects) return false;
  const BodyTool* body = view.tool().body.get();
  if (body == nullptr) return can_travel(view.objects()[object]);
  return can_travel(*body) &&
         (!is_fitted(view.objects()[object].shape) || view.sampled_mesh(object) != nullptr);
}

LocalModel local_model(const ToolView& view, const Vec3& position, const TouchMemory& memory,
                       const KnownSurfaces& known) noexcept {
  return model_of(view, view.objects(), position, memory, known);
}

LocalModel local_model(const ToolView& view, const std::vector<Object>& objects,
                       const Vec3& position, const TouchMemory& memory) noexcept {
  return model_of(view, objects, position, memory, {});
}

LocalModel local_model(const World& world, const Vec3& position, const TouchMemory& memory,
                       std::size_t held, const KnownSurfaces& known) noexcept {
  LocalModel model = model_of(world.view(held), world.objects(held), position, memory, known);
  for (int i = 0; i < model.count; ++i) {
    SurfacePatch& patch = model.patches[static_cast<std::size_t>(i)];
    patch.velocity = world.velocity_at(patch.object, patch.point);
    // A body that the server has reset becomes softer. The stiffness of a surface must stay above
    // zero.
    const double trust = std::max(kLeastTrust, world.trust(patch.object));
    patch.material.stiffness *= trust;
    patch.material.damping *= trust;
    patch.material.viscous_friction *= trust;
  }
  return model;
}

}  // namespace feltwire
