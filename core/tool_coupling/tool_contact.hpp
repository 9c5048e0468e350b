#pragma once
// The contact of a tool with a body: generalised forces, their stiffness, and the places with
// friction.

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "core/base/types.hpp"

namespace feltwire {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// The points at which one object touches the tool with normals near one axis of its frame.
/// Friction there may hold the tool along the surface.
struct FrictionPatch {
  double load = 0.0;  // [N] sum of the points' forces, each by its magnitude
  double static_friction = 0.0, dynamic_friction = 0.0;
  /// For a motion m of the tool against the object, m^T slip m is the mean square of the points'
  /// slip [m^2], weighted by their load. The points count as those of a plane: only motion across
  /// the mean normal and about it is slip. So a tool that only rocks does not slip.
  Mat6 slip = Mat6::Zero();
  Vec6 carried =
      Vec6::Zero();  // movement of the object itself in the step, about the tool's origin
  std::uint32_t object = 0;
};

/// The force and torque of one of the solids.
struct ObjectWrench {
  std::uint32_t object = 0;
  Vec6 wrench = Vec6::Zero();  // [N], [N m] on the tool
};

/// A resistance in proportion to speed.
struct Damper {
  Mat6 resistance = Mat6::Zero();  // [N s/m] ... minus the force over the velocity
  Vec6 driven = Vec6::Zero();      // resistance times the motion of the solids in the step

  void add(const Mat6& more, const Vec6& carried) noexcept {
    resistance += more;
    driven += more * carried;
  }
};

/// The contact of a tool with the solids. Generalised vectors are translation, then rotation,
/// world frame, about the tool's origin.
struct ShellContact {
  double energy = 0.0;            // [J] stored in the solids
  Vec6 wrench = Vec6::Zero();     // [N], [N m] on the tool: minus the gradient of the energy
  Mat6 stiffness = Mat6::Zero();  // [N/m] ... the positive part of the energy's second derivative
  Mat6 softening = Mat6::Zero();  // [N/m] ... what is to be taken off it, as far as it is known
  double clearance = std::numeric_limits<double>::infinity();  // [m] no free point is nearer to a
                                                               // surface than this
  std::size_t touching = 0;                                    // points inside a solid
  std::size_t looked_at = 0;  // nodes and points whose distance was computed

  static constexpr std::size_t kFrictionPatches = 8;
  std::array<FrictionPatch, kFrictionPatches> patches;
  std::array<ObjectWrench, kFrictionPatches> parts;  // of the wrench
  std::size_t grip_count = 0, part_count = 0;
  Damper damping;    // of the contact, along the normals
  Damper viscosity;  // along the surface

  std::span<const FrictionPatch> gripping() const { return {patches.data(), grip_count}; }
  std::span<const ObjectWrench> touched() const { return {parts.data(), part_count}; }
};

}  // namespace feltwire
