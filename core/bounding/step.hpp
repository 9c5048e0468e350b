#pragma once

#include "core/base/contact_normals.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// The input of one bounding step: the movement of the device while the last force was held, and
/// the command for the next.
template <class Real>
struct BasicBoundingStep {
  Vector3<Real> displacement = Vector3<Real>::Zero();  // dx(n) = x(n) - x(n-1) [m]
  Vector3<Real> rotation =
      Vector3<Real>::Zero();  // dtheta(n), rotation vector of q(n) q(n-1)^-1 [rad]
  Real hold_time = 0;  // [s] how long the last force was really held; shorter than T counts as T
  BasicCommand<Real> command;  // f_e(n), on the hand
  bool local = false;  // the command was made at the device, half a sample ahead (midpoint.hpp)
  /// The normals of the contacts whose forces add up to command.elastic, if there are several.
  /// Null: one contact, or not known.
  const ContactNormals* normals = nullptr;
};
using BoundingStep = BasicBoundingStep<double>;

/// The place at which to ask the scene, relative to the device.
template <class Real>
struct BasicProbe {
  Vector3<Real> offset = Vector3<Real>::Zero();    // [m]
  Vector3<Real> rotation = Vector3<Real>::Zero();  // [rad] rotation vector, world frame
};
using Probe = BasicProbe<double>;

}  // namespace feltwire
