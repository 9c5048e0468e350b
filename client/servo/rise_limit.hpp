#pragma once
// Limits the rise of a force that is made at the device, if surfaces change under the hand.

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"
#include "core/local_model/body_model.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// [N] by which the force of a model's surfaces may rise while the tool moves by `way` [m].
double rise(const LocalModel& model, double way, double elapsed) noexcept;

/// The force of a local model may rise as the tool moves over its surfaces; beyond that it rises no
/// faster than a slew limit. So a resting hand feels no step if the scene is changed, if a surface
/// enters the model, or if the model is used again. A bound like contact_frame does this by itself;
/// a shaping method renders the model's command.
class RiseLimit {
 public:
  /// `slew` [N/s], `torque_slew` [N m/s].
  RiseLimit(double slew, double torque_slew) : slew_(slew), torque_slew_(torque_slew) {}

  /// Returns the command, scaled down if it rose faster. The tool moved by `way` [m] over `elapsed`
  /// [s]. `beside` [N]: the force that surfaces outside the model may add.
  Command apply(const Command& command, const LocalModel& model, double way, double elapsed,
                double beside = 0.0) noexcept;

  /// Limits force and torque for a tool with a body, whose spring couples it to the device. The
  /// device moved by `way` [m] and turned by `turn` [rad]. One scale for force and torque.
  /// `inertia`: of a tool with mass; null: it has none.
  Command apply(const Command& command, const BodyModel& model, double way, double turn,
                double elapsed, const ToolInertia* inertia = nullptr) noexcept;

  /// Takes the command that the hand holds after a tick without apply().
  void given(const Command& held) noexcept {
    last_ = length(held.force());
    last_torque_ = length(held.torque);
  }

 private:
  double slew_, torque_slew_;
  double last_ = 0.0;         // [N]
  double last_torque_ = 0.0;  // [N m]
};

}  // namespace feltwire
