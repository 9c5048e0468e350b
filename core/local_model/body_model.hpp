#pragma once
// The local model of a tool with a body: parts of its surface against planes, and the spring that
// couples it to the device. The server sends it besides the force, and the client finds the tool's
// balance itself at its own servo rate. It is the linearised contact of Otaduy & Lin (Sensation
// preserving simplification for haptic rendering, 2003; A modular haptic rendering algorithm for
// stable and transparent 6-DOF manipulation, 2006), kept contact by contact: the 6x6 stiffness is
//   K = sum over the points inside of k J^T J,   J = (n^T, (a x n)^T).
// It is symmetric and positive semidefinite for every k >= 0, and no contact pulls.

#include <array>
#include <cstdint>
#include <span>

#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// A place where points of the tool may grip: on one object, with normals near one axis of its
/// frame.
struct BodyPatch {
  double static_friction = 0.0, dynamic_friction = 0.0;
  double viscous_friction = 0.0;  // [N s/m] of the object
  double damping_time = 0.0;      // [s] along the normal: damping over stiffness
  Vec3 velocity = Vec3::Zero();   // [m/s] of the surface
  std::uint16_t object = 0;
};

/// A part of the tool's surface, and the plane that it meets. Its points lie about `arm` with the
/// covariance `spread`. Along the normal they are assumed to be spread evenly, so a part comes into
/// contact point by point.
struct BodyPoint {
  Vec3 arm = Vec3::Zero();      // [m, tool frame] of its centre, from the tool's origin
  Mat3 spread = Mat3::Zero();   // [m^2, tool frame] symmetric, positive semidefinite
  Vec3 normal = Vec3::UnitZ();  // unit, world frame, towards the free side
  double distance = 0.0;        // [m] of the centre when the tool has the model's pose; < 0: inside
  double stiffness = 0.0;       // [N/m] >= 0, of all its points
  std::uint8_t patch = 0;
};

/// Integrals of the evenly spread depths x + u, |u| <= half, each over all points with a depth
/// above zero.
struct PressedPart {
  double share = 0.0, first = 0.0, second = 0.0;  // of the points; means of u [m] and u^2 [m^2]
  double depth = 0.0;                             // [m] mean of x + u
  double moment = 0.0;                            // [m^2] mean of (x + u) u
  double square = 0.0;                            // [m^2] mean of (x + u)^2
  double pressed_square = 0.0;                    // [m^3] mean of (x + u) u^2
};
PressedPart pressed_part(double depth, double half) noexcept;

inline constexpr int kMaxBodyPoints = 15;
inline constexpr int kMaxBodyPatches = 3;

/// The contacts of a tool, valid while way / reach + angle / turn of its movement is below 1.
struct BodyModel {
  std::uint32_t scene = 0;  // as in LocalModel
  /// The version of the solids that the receiver has in full (PrefetchedTool::version): they are
  /// met besides the points. 0: the points are all that is met.
  std::uint32_t solids = 0;
  Pose tool;              // the pose at which the contacts held the tool when the model was made
  double reach = 0.0;     // [m] 0: the model is empty
  double turn = 0.0;      // [rad]
  ToolCoupling coupling;  // nothing in it is zero
  double radius = 0.0;    // [m] of the tool's farthest point from its origin
  bool slipping = false;  // along a surface
  std::array<BodyPoint, kMaxBodyPoints> points{};
  int count = 0;
  std::array<BodyPatch, kMaxBodyPatches> patches{};
  int patch_count = 0;

  std::span<const BodyPoint> view() const {
    return {points.data(), static_cast<std::size_t>(count)};
  }
  std::span<const BodyPatch> surfaces() const {
    return {patches.data(), static_cast<std::size_t>(patch_count)};
  }
};

/// The contact of the tool with the model's planes, and with `solids`; null: there are none. The
/// planes have moved with their surfaces for `age` [s] since the model was made, and for `elapsed`
/// [s] in this step.
class ModelledSurroundings final : public ToolSurroundings {
 public:
  ModelledSurroundings(const BodyModel& model, double age, double elapsed,
                       const ToolSurroundings* solids = nullptr)
      : model_(model), age_(age), elapsed_(elapsed), solids_(solids) {}
  using ToolSurroundings::contact;
  ShellContact contact(const Pose& tool, WorkLimit* work) const noexcept override;

 private:
  void add_planes(const Pose& tool, ShellContact& sum) const noexcept;

  const BodyModel& model_;
  double age_, elapsed_;
  const ToolSurroundings* solids_;
};

}  // namespace feltwire
