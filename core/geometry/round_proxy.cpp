#include "core/geometry/round_proxy.hpp"

namespace feltwire {
namespace {

/// Computes the contact of a proxy with this normal, for a tool that moved from memory.proxy to p.
SurfacePoint held_on_round(const RoundSolid& solid, const Vec3& p, const Vec3& normal,
                           FeatureMemory& memory) {
  const Vec3 core = solid.core(p), offset = p - core;
  const double distance = length(offset);
  SurfacePoint on;
  if (normal == direction(offset)) {
    if (!(distance < solid.radius)) return free_at(p, memory);
    on = {core + solid.radius * normal, normal, std::abs(solid.radius - distance)};
  } else {
    if (!(distance < solid.radius) && !holds_behind(solid, normal, p)) return free_at(p, memory);
    on.point = solid.core_of(normal, p) + solid.radius * normal;
    const Polar<double> back = polar(Vec3(on.point - p));
    on.normal = back.length > 0.0 ? back.direction : normal;
    on.depth = back.length;
  }
  memory = {};
  memory.feature = 1;
  memory.side = 1;
  memory.normal = normal;
  memory.proxy = p;
  memory.tracked = true;
  return on;
}

}  // namespace

SurfacePoint hollow_surface(const Vec3& p, const Vec3& core, double radius, FeatureMemory& memory) {
  const Vec3 offset = p - core;
  const double distance = length(offset);
  if (!(distance > radius)) return no_contact(memory);
  const Vec3 outward = direction(offset);
  return stand_on(core + radius * outward, -outward, std::abs(radius - distance), 0, memory);
}

SurfacePoint round_from_outside(const RoundSolid& solid, const Vec3& p, const Vec3& undefined,
                                FeatureMemory& memory) {
  const Vec3 offset = p - solid.core(p);
  const double off = length(offset) - solid.radius;
  Vec3 normal = direction(offset);
  if (normal.isZero(0.0)) normal = undefined;
  if (memory.feature != 0) {
    normal = round_normal(solid, memory.proxy, p, memory.normal);
  } else {
    Span in;
    if (memory.tracked && !cannot_have_met(off, p - memory.proxy))
      in = within(solid, memory.proxy, p - memory.proxy);
    if (in.in < in.out) {
      const Vec3 entry = memory.proxy + in.in * (p - memory.proxy);
      const Vec3 outward = direction(Vec3(entry - solid.core(entry)));
      if (!outward.isZero(0.0)) normal = round_normal(solid, entry, p, outward);
    } else if (!(off < 0.0)) {
      return free_at(p, memory);
    }
  }
  return held_on_round(solid, p, normal, memory);
}

}  // namespace feltwire
