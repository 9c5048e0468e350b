#pragma once
// A curved surface as the ball or the cylinder that it is most like.

#include "core/base/types.hpp"

namespace feltwire {

/// A patch stands for the surface as far as that lies within this share of the way from the patch's
/// point: what a client errs by is a share of how far it has gone since.
inline constexpr double kPatchSlope = 1.0 / 64.0;

/// The ball or the cylinder that a surface is most like whose normal turns by
/// [uu uv; uv vv] [1/m] along the unit tangents u and v.
struct Bend {
  double curvature = 0.0;    // [1/m] as a SurfacePatch has it
  Vec3 axis = Vec3::Zero();  // unit: straight along it; zero: a ball
};
Bend bend(const Vec3& u, const Vec3& v, double uu, double uv, double vv) noexcept;

}  // namespace feltwire
