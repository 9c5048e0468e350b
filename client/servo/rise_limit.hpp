#pragma once
// Keeps a force that is made at the device from stepping where surfaces change under the hand.

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"
#include "core/local_model/body_model.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// The force of a local model may rise as the tool moves over its surfaces, and beyond that no
/// faster than a slew. So a hand that rests feels no step when the scene is changed, when a surface
/// comes into the model, or when the model says something again. A bound like contact_frame does
/// that by itself; shaping renders what the model says.
class RiseLimit {
 public:
  /// `slew` [N/s], `torque_slew` [N m/s].
  RiseLimit(double slew, double torque_slew) : slew_(slew), torque_slew_(torque_slew) {}

  /// The command, scaled down where it rose faster. The tool moved by `way` [m] over `elapsed` [s].
  /// `more`: surfaces beside the model's; null: none.
  Command apply(const Command& command, const LocalModel& model, double way, double elapsed,
                const LocalModel* more = nullptr) noexcept;

  /// The same for a tool with a body, whose spring couples it to the device, and for torque. The
  /// device moved by `way` [m] and turned by `turn` [rad]. One scale for force and torque.
  Command apply(const Command& command, const BodyModel& model, double way, double turn,
                double elapsed) noexcept;

  /// Tells what the hand holds after a tick that did not call apply().
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
