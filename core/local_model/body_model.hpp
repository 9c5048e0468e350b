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

#include "core/coupled_tool/coupled_tool.hpp"
#include "core/coupled_tool/tool_body.hpp"
#include "core/geometry/shapes.hpp"
#include "core/material/material.hpp"

namespace feltwire {

/// Where points of the tool may grip: of one object, with normals near one axis of its frame.
struct BodyPatch {
  double static_friction = 0.0, dynamic_friction = 0.0;
  double viscous_friction = 0.0;  // [N s/m] of the object
  double damping_time = 0.0;      // [s] along the normal: damping over stiffness
  Vec3 velocity = Vec3::Zero();   // [m/s] of the surface
  std::uint16_t object = 0;
};

/// A part of the tool's surface, and the plane that it meets. Its points lie about `arm` with the
/// covariance `spread`; along the normal they are taken for evenly spread. So a part comes into
/// contact point by point.
struct BodyPoint {
  Vec3 arm = Vec3::Zero();      // [m, tool frame] of its centre, from the tool's origin
  Mat3 spread = Mat3::Zero();   // [m^2, tool frame] symmetric, positive semidefinite
  Vec3 normal = Vec3::UnitZ();  // unit, world frame, towards the free side
  double distance = 0.0;   // [m] of the centre where the tool has the model's pose; < 0: inside
  double stiffness = 0.0;  // [N/m] >= 0, of all its points
  std::uint8_t patch = 0;
};

/// What a part's evenly spread depths x + u, |u| <= half, come to, each over all points and counted
/// where it is above zero.
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

/// A solid with a formula near the tool. To a client that knows the tool's body this is the scene.
struct BodySolid {
  Primitives::And<> shape;
  Side felt_from = Side::outside;
  Pose pose;                                             // when the model was made
  Material material;                                     // as far as it is felt; stiffness >= 0
  Vec3 velocity = Vec3::Zero(), turning = Vec3::Zero();  // [m/s] of its origin, [rad/s]
  std::uint16_t object = 0;

  /// [m/s] of its surface at a place.
  Vec3 velocity_at(const Vec3& place) const {
    return velocity + turning.cross(place - pose.position);
  }
};
inline constexpr int kMaxBodySolids = 4;

/// All that a tool meets while way / reach + angle / turn of its movement is below 1.
struct BodyModel {
  std::uint32_t scene = 0;  // as in LocalModel
  Pose tool;                // where it was made: where the contacts held the tool
  double reach = 0.0;       // [m] 0: the model says nothing
  double turn = 0.0;        // [rad]
  ToolCoupling coupling;    // nothing in it is zero
  double radius = 0.0;      // [m] of the tool's farthest point from its origin
  bool slipping = false;    // along a surface
  std::array<BodyPoint, kMaxBodyPoints> points{};
  int count = 0;
  std::array<BodyPatch, kMaxBodyPatches> patches{};
  int patch_count = 0;
  /// Of the ToolBody that meets the solids. 0: no solids, and the parts above are all there is.
  std::uint32_t body = 0;
  std::array<BodySolid, kMaxBodySolids> solids{};
  int solid_count = 0;

  std::span<const BodyPoint> view() const {
    return {points.data(), static_cast<std::size_t>(count)};
  }
  std::span<const BodyPatch> surfaces() const {
    return {patches.data(), static_cast<std::size_t>(patch_count)};
  }
  std::span<const BodySolid> near() const {
    return {solids.data(), static_cast<std::size_t>(solid_count)};
  }
};

/// [m/s] The largest speed at which a surface of the model takes the tool with it.
double largest_speed(const BodyModel& model) noexcept;

/// The contact of the tool with the model's planes and solids, which have gone on for `age` [s]
/// since the model was made, and for `elapsed` [s] in this step. `body`: as the model means it;
/// null where that is not known, and then there are no solids.
class ModelledSurroundings final : public ToolSurroundings {
 public:
  ModelledSurroundings(const BodyModel& model, const ToolBody* body, double age, double elapsed)
      : model_(model), body_(body), age_(age), elapsed_(elapsed) {}
  ShellContact contact(const Pose& tool) const noexcept override;

 private:
  void add_parts(const Pose& tool, ShellContact& sum) const noexcept;

  const BodyModel& model_;
  const ToolBody* body_;
  double age_, elapsed_;
};

}  // namespace feltwire
