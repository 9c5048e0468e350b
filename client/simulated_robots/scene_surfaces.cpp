#include "client/simulated_robots/scene_surfaces.hpp"

#include <stdexcept>

#include "core/local_model_extraction/extract.hpp"

namespace feltwire {
namespace {

const Scene& checked(const std::shared_ptr<const Scene>& scene) {
  if (!scene) throw std::invalid_argument("a model of surfaces needs a scene");
  if (scene->tool().body)
    throw std::invalid_argument("scene '" + scene->name() +
                                "': its tool is no point; give a scene without a \"tool\"");
  return *scene;
}

}  // namespace

SceneSurfaces::SceneSurfaces(std::shared_ptr<const Scene> scene)
    : scene_(std::move(scene)), memory_(checked(scene_).memory()) {}

SurfacePrior SceneSurfaces::nearest(const Vec3& tip, double /*elapsed*/) noexcept {
  if (!tip.allFinite()) return {};
  const ToolView& view = scene_->views().front();
  view.touch({tip, Vec3::Zero()}, memory_);
  const LocalModel model = local_model(view, tip, memory_);
  if (model.count == 0) return {};
  const SurfacePatch& patch = model.patches.front();
  const Vec3 point = patch.point + patch.offset * patch.normal;
  if (!((tip - point).norm() <= kReach)) return {};
  return {.key = std::uint32_t{1} + patch.object,
          .point = point,
          .normal = patch.normal,
          .stiffness = patch.material.stiffness,
          .friction = patch.material.dynamic_friction,
          .velocity = patch.velocity};
}

}  // namespace feltwire
