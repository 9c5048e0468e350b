#pragma once
// The common part of the proxies of a ball in the hand.

#include "core/base/numeric.hpp"
#include "core/geometry/primitive.hpp"

namespace feltwire {

/// Moves the proxy of the ball's centre back by the radius, to the point where the ball touches the
/// surface.
inline SurfacePoint under(SurfacePoint centre, double radius) {
  if (centre.depth > 0.0) centre.point -= radius * centre.normal;
  return centre;
}

/// The same for a round solid. If the centre was pushed past the middle, the surface's normal there
/// belongs to another side than the one that the ball touches: use the remembered normal.
inline SurfacePoint under_round(SurfacePoint centre, double radius, const FeatureMemory& memory,
                                Side side) {
  if (side == Side::inside) return under(centre, radius);
  if (centre.depth > 0.0) centre.point -= radius * memory.normal;
  return centre;
}

/// A ball outside a solid with edges, which the ball rounds: uses the signed distance while the
/// centre is outside the solid, and the solid's own proxy while it is inside.
template <Primitive Solid>
SurfacePoint rounded(const Solid& solid, const Vec3& p, double radius, FeatureMemory& memory) {
  const SurfacePoint inside = solid.surface_point(Side::outside, p, memory);
  if (inside.depth > 0.0) return {inside.point, inside.normal, inside.depth + radius};
  const FieldPoint field = solid.signed_distance(p);
  const Polar<double> out = polar(field.gradient);
  if (!(field.distance < radius) || !(out.length > 0.0)) return {};
  memory.normal = out.direction;
  return {p - field.distance * out.direction, out.direction, radius - field.distance};
}

}  // namespace feltwire
