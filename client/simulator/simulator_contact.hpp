#pragma once
// The surfaces near the tool, as a program's own simulator tells them.

#include "core/base/types.hpp"
#include "core/local_model/local_model.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {

/// An answer of the simulator to one pose of the tool. World frame.
struct SimulatorContact {
  Nanoseconds seen{0};  // monotonic time of the servo tick whose pose the simulator used
  bool modelled = false;
  /// If modelled: the surfaces within model.reach of the tool, as they were at that tick. The port
  /// sets model.center.
  LocalModel model;
  /// Else: the force and the torque on the hand, at the pose of that tick.
  Command command;
  /// [N/m] of the force when the tool moves along it; 0: not known.
  double stiffness = 0.0;
};

/// Returns the plane that pushes a tool at `position` with `force` and has this stiffness [N/m]. It
/// counts within twice its depth, and within `least_reach` [m] at least. Preconditions: the
/// stiffness is above zero, the force is finite and not zero.
LocalModel plane_of(const Vec3& position, const Vec3& force, double stiffness, double least_reach);

}  // namespace feltwire
