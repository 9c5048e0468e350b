#pragma once

#include "core/teleoperation/contact_estimator.hpp"

namespace feltwire {

/// A model of what a robot may touch. It may be wrong: what the robot touches corrects it
/// (ContactEstimator).
class SurfaceModel {
 public:
  SurfaceModel() = default;
  SurfaceModel(const SurfaceModel&) = delete;
  SurfaceModel& operator=(const SurfaceModel&) = delete;
  virtual ~SurfaceModel() = default;

  /// The surface that is nearest to the tool's tip [m], in the robot's frame; key 0: none is near.
  /// `elapsed` [s] since the last call, for what moves. Called from the servo thread: it must not
  /// block, allocate or throw.
  virtual SurfacePrior nearest(const Vec3& tip, double elapsed) noexcept = 0;
};

}  // namespace feltwire
