#pragma once
// The surroundings of the bench of three degrees of freedom: a ball, or a block with a hole, both
// with friction, as a point meets them.

#include <cstdint>

#include "core/base/types.hpp"
#include "core/teleoperation/contact_estimator.hpp"

namespace feltwire::teleop::in_space {

/// A ball around the origin; or a block whose top is at z = 0, with a round hole along z. The point
/// is the axis of the peg at its lower end, so the hole has the radius of the peg's play, and the
/// peg does not tilt.
struct Shape {
  enum class Kind : std::uint8_t { ball, hole };
  Kind kind = Kind::ball;
  double radius = 0.1;        // [m] of the ball
  double play = 0.25e-3;      // [m] of the hole, from its axis
  double chamfer = 2e-3;      // [m] of the hole's edge, at 45 degrees
  double depth = 0.04;        // [m] of the hole
  double sunk = 0.0;          // [m] the top is at -sunk
  double stiffness = 2000.0;  // [N/m] in all directions
  double damping = 2.0;       // [N s/m] along the normal
  double friction = 0.3;      // mu
};

/// The place of the surface that is nearest to a point.
struct NearestPlace {
  Vec3 point = Vec3::Zero();  // [m]
  bool free = true;           // the point is not in the material
  std::uint32_t face = 1;     // of the ball 1; of the block 1 top, 2 chamfer, 3 wall, 4 ground
};
NearestPlace nearest_place(const Shape& shape, const Vec3& point);

/// The place on the surface, or in front of it, where a tool without mass would be that a spring
/// draws to a goal. Friction holds it within the cone around the normal:
///   |along the surface| <= mu |along the normal|    of goal less place
/// It goes to a goal in short steps, so it stays on its side of an edge.
class SurfaceProxy {
 public:
  SurfaceProxy(const Shape& shape, const Vec3& start) : shape_(shape), place_(start) {}

  /// The goal [m] of now. Returns the place [m].
  const Vec3& follow(const Vec3& goal);
  /// [N] on a tool at `goal` that a spring pulls to the place.
  Vec3 force(const Vec3& goal, double stiffness) const { return stiffness * (place_ - goal); }

 private:
  bool step(const Vec3& goal);

  Shape shape_;
  Vec3 place_;
};

/// The surface near the tip, as a model has it that is 2 mm too deep and a quarter too soft.
SurfacePrior wrong_model(const Shape& shape, const Vec3& tip);

}  // namespace feltwire::teleop::in_space
