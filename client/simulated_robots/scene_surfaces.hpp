#pragma once

#include <memory>

#include "core/scene/scene.hpp"
#include "core/teleoperation/surface_model.hpp"

namespace feltwire {

/// The objects of a scene as the model of what a robot's tip may touch: place, normal, stiffness
/// and dynamic friction of the nearest one. An object is one surface, whatever its shape. Bodies
/// stand where the file has them.
class SceneSurfaces final : public SurfaceModel {
 public:
  /// [m] Surfaces that are farther from the tip are not told.
  static constexpr double kReach = 0.1;

  /// Throws std::invalid_argument where the tool of the scene is not a point.
  explicit SceneSurfaces(std::shared_ptr<const Scene> scene);

  SurfacePrior nearest(const Vec3& tip, double elapsed) noexcept override;

 private:
  std::shared_ptr<const Scene> scene_;
  TouchMemory memory_;
};

}  // namespace feltwire
