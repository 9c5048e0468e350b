#pragma once
// Approximates a curved surface by a ball or a cylinder.

#include "core/base/types.hpp"

namespace feltwire {

/// A patch represents the surface up to this relative error: the error of a client is a share of
/// its distance from the patch's point.
inline constexpr double kPatchSlope = 1.0 / 64.0;

/// Returns the ball or the cylinder that approximates a surface whose normal turns by [uu uv; uv
/// vv] [1/m] along the unit tangents u and v.
struct LocalCurvature {
  double curvature = 0.0;    // [1/m] sign and size as in SurfacePatch
  Vec3 axis = Vec3::Zero();  // unit vector along which the surface is straight; zero: a ball
};
LocalCurvature local_curvature(const Vec3& u, const Vec3& v, double uu, double uv,
                               double vv) noexcept;

}  // namespace feltwire
