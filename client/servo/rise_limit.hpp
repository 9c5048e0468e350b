#pragma once
// Keeps a force that is made at the device from stepping where surfaces change under the hand.

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"
#include "core/local_model/local_model.hpp"

namespace feltwire {

/// [N] that the force of a model's surfaces may rise by while the tool moves by `way` [m].
double rise(const LocalModel& model, double way, double elapsed) noexcept;

/// The force of a local model may rise as the tool moves over its surfaces, and beyond that no
/// faster than a slew. So a hand that rests feels no step when the scene is changed, when a surface
/// comes into the model, or when the model says something again. A bound like contact_frame does
/// that by itself; shaping renders what the model says.
class RiseLimit {
 public:
  /// `slew` [N/s].
  explicit RiseLimit(double slew) : slew_(slew) {}

  /// The command, scaled down where it rose faster. The tool moved by `way` [m] over `elapsed` [s].
  /// `beside` [N]: what other surfaces than the model's may add.
  Command apply(const Command& command, const LocalModel& model, double way, double elapsed,
                double beside = 0.0) noexcept;

  /// Tells the force that the hand holds after a tick that did not call apply().
  void given(const Vec3& force) noexcept { last_ = length(force); }

 private:
  double slew_;
  double last_ = 0.0;  // [N]
};

}  // namespace feltwire
