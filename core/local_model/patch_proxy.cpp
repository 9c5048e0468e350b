#include "core/local_model/patch_proxy.hpp"

#include <array>
#include <span>

#include "core/base/numeric.hpp"
#include "core/geometry/half_spaces.hpp"
#include "core/geometry/round_proxy.hpp"
#include "core/local_model/local_contact.hpp"

namespace feltwire {
namespace {

constexpr double kExact = 1e-12;  // tolerance, as a share of a depth or height

bool solid(double height) { return height < 0.0; }  // A NaN counts as free space.

/// A patch and the tool's height above it.
struct PatchView {
  const SurfacePatch* patch = nullptr;
  double height = 0.0;  // [m] height of the tool above the patch
  Vec3 normal = Vec3::Zero();
  double before = 0.0;  // [m] height of the tool above the patch before this movement

  /// Returns the height [m] of the tool above the patch plus its offset.
  double clearance() const { return height - patch->offset; }
  /// Returns the half space in front of the patch's tangent plane, shifted by the offset.
  HalfSpace open(const Vec3& tool) const { return {normal, normal.dot(tool) - clearance()}; }
  /// Returns the half space behind the patch's tangent plane, without the offset.
  HalfSpace closed(const Vec3& tool) const { return {-normal, height - normal.dot(tool)}; }
};

struct SeenPatches {
  std::array<PatchView, kMaxPatches> all{};
  std::size_t count = 0;
  std::span<const PatchView> view() const { return {all.data(), count}; }
  void add(const PatchView& seen) { all[count++] = seen; }
};

/// Computes the proxy for patches that are not joined. The proxy is the nearest point in front of
/// all tangent planes.
PatchProxy before_all(const SeenPatches& seen, const Vec3& tool) {
  PatchProxy proxy;
  std::array<HalfSpace, kMaxPatches> spaces;
  Vec3 beyond = Vec3::Zero();
  double deepest = 0.0;  // [m] largest depth behind a patch
  int count = 0;
  for (std::size_t i = 0; i < seen.count; ++i) {
    const PatchView& one = seen.all[i];
    spaces[i] = one.open(tool);
    const double height = one.clearance();
    if (!solid(height)) continue;
    beyond -= height * one.normal;
    if (++count == 1 || -height > deepest) {
      proxy.patch = one.patch;
      deepest = -height;
      if (count == 1) proxy.surface.normal = one.normal;
    }
  }
  if (count == 0) return proxy;
  const bool alone = count == 1 && seen.count == 1;
  if (!alone) {
    const NearestPoint nearest = nearest_in({spaces.data(), seen.count}, tool, kExact * deepest);
    if (nearest.found) beyond = nearest.point - tool;
  }
  proxy.surface.point = tool + beyond;
  proxy.surface.depth = alone ? deepest : length(beyond);
  if (!alone) proxy.surface.normal = direction(beyond);
  return proxy;
}

/// Returns the patch on which the proxy lies. This is a patch other than `from` if the proxy must
/// cross an obtuse edge to reach the point of `from` closest to the tool.
PatchView slid(const SeenPatches& seen, const PatchView& from, const Vec3& tool, double age) {
  constexpr double kBeyond = 1e-9;  // tolerance, as a share of the depth
  const Vec3 closest = tool - from.height * from.normal;
  PatchView to = from;
  double highest = -kBeyond * from.height;
  for (const PatchView& other : seen.view()) {
    if (other.patch == from.patch) continue;
    const SurfacePatch& patch = *other.patch;
    const double above = height_above(patch, age * patch.velocity, closest).height;
    if (!(above > highest)) continue;
    highest = above;
    to = other;
  }
  return to;
}

/// Computes the proxy of a ball on an edge, a corner or a face of joined patches. The ball touches
/// the nearest point of the solid behind all tangent planes.
PatchProxy round_edge(const SeenPatches& seen, const PatchView& highest, const Vec3& tool) {
  std::array<HalfSpace, kMaxPatches> spaces;
  for (std::size_t i = 0; i < seen.count; ++i) spaces[i] = seen.all[i].closed(tool);
  const NearestPoint nearest =
      nearest_in({spaces.data(), seen.count}, tool, kExact * highest.patch->offset);
  const Vec3 out =
      nearest.found ? Vec3(tool - nearest.point) : Vec3(highest.height * highest.normal);
  const Polar<double> away = polar(out);
  const Vec3 normal = away.length > 0.0 ? away.direction : highest.normal;
  const double depth = highest.patch->offset - away.length;
  if (!(depth > 0.0)) return {};
  return {highest.patch, {tool + depth * normal, normal, depth}};
}

/// Returns the face that a ball reaches from a round edge or corner, when the ball's centre is
/// behind all patches. It is the face with the steepest descent. Returns null if the ball was on no
/// edge or corner.
const PatchView* fallen(const SeenPatches& seen, const Vec3& tool, const FeatureMemory& before) {
  constexpr double kRound = 1e-9;    // 1 minus the cosine of the angle between the normals
  constexpr double kTouched = 1e-3;  // tolerance, as a share of the ball's radius
  const PatchView* best = nullptr;
  double steepest = 0.0;
  for (const PatchView& one : seen.view()) {
    const double offset = one.patch->offset, cosine = one.normal.dot(before.normal);
    if (before.feature == 0 || !(offset > 0.0)) return nullptr;
    if (before.feature == one.patch->feature && !(1.0 - cosine > kRound)) return nullptr;
    const Vec3 way = tool - (before.proxy - offset * before.normal);
    if (one.height - one.normal.dot(way) < -kTouched * offset) continue;
    const double fall = direction(Vec3(one.normal - cosine * before.normal)).dot(way);
    if (best != nullptr && !(fall > steepest)) continue;
    best = &one;
    steepest = fall;
  }
  return best;
}

/// Returns the patch through which the tool entered the solid behind all patches. Returns null if
/// the tool did not enter.
const PatchView* entry(const SeenPatches& seen) {
  const PatchView* by = nullptr;
  double in = 0.0, out = 1.0;
  for (const PatchView& one : seen.view()) {
    const double part = one.before / (one.before - one.height);
    if (!solid(one.before)) {
      if (!solid(one.height)) return nullptr;
      if (by != nullptr && !(part > in)) continue;
      in = part;
      by = &one;
    } else if (!solid(one.height)) {
      out = std::min(out, part);
    }
  }
  return in < out ? by : nullptr;
}

/// Returns true if the straight line from the tool back to the face `by` lies in the solid.
bool holds(const SeenPatches& seen, const PatchView& by) {
  double from = 0.0, to = -by.height;  // [m] limits on the line along the face's normal
  for (const PatchView& one : seen.view()) {
    if (one.patch == by.patch) continue;
    const double rises = one.normal.dot(by.normal);
    if (rises < 0.0)
      from = std::max(from, one.height / -rises);
    else if (!solid(one.height))
      return false;
    else if (rises > 0.0)
      to = std::min(to, -one.height / rises);
  }
  return from < to;
}

/// Computes the proxy for joined patches. The proxy stays on the patch through which the tool
/// entered, while the solid is between this patch and the tool. If this patch is unknown, the proxy
/// is on the nearest patch.
PatchProxy behind_all(const SeenPatches& seen, const Vec3& tool, double age,
                      const FeatureMemory& before, bool came) {
  const PatchView* highest = nullptr;
  const PatchView* by = nullptr;
  bool inside = true;
  for (const PatchView& one : seen.view()) {
    inside &= solid(one.height);
    if (highest == nullptr || one.height > highest->height) highest = &one;
    if (before.feature == one.patch->feature) by = &one;
  }
  if (highest == nullptr) return {};
  if (came && before.feature == 0) by = entry(seen);
  if (by != nullptr) inside = holds(seen, *by);
  if (by == nullptr) by = highest;
  if (!inside) {
    if (highest->patch->offset > 0.0) return round_edge(seen, *highest, tool);
    return {};
  }
  const PatchView* down = fallen(seen, tool, before);
  const PatchView on = slid(seen, down != nullptr ? *down : *by, tool, age);
  const double depth = -on.clearance();
  if (!(depth > 0.0)) return {};
  return {on.patch, {tool + depth * on.normal, on.normal, depth}};
}

/// Corrects the height above a round patch if the proxy stayed on another side of its ball or
/// cylinder (round_proxy.hpp). If the tool was not in contact with this patch before, `from` shows
/// whether the tool has entered the solid.
void leave_behind(PatchView& seen, const Vec3& moved, const Vec3& moved_then, const Vec3& tool,
                  const FeatureMemory& before, const CameFrom& from) {
  constexpr double kRounding = 1e-9;
  const SurfacePatch& patch = *seen.patch;
  const bool held = before.feature != 0 && before.feature == patch.feature;
  if (!(patch.curvature > 0.0) || (!held && !from.known)) return;
  // Returns the position relative to the centre of curvature.
  const auto about = [&](const Vec3& p, const Vec3& patch_moved) {
    Vec3 d = p - (patch.point + patch_moved);
    d -= along(d, patch.axis);
    return Vec3(patch.normal / patch.curvature + d);
  };
  const RoundSolid solid{1.0 / patch.curvature + patch.offset, 0.0};
  const Vec3 to = about(tool, moved), outward = direction(to);
  const Vec3 origin = from.known ? about(from.position, moved_then) : to;
  Vec3 normal = outward;
  if (held) {
    const Vec3 proxy = from.known ? direction(about(before.proxy, moved)) : before.normal;
    if (!proxy.isZero(0.0)) normal = round_normal(solid, origin, to, proxy);
  } else {
    const Span in = within(solid, origin, to - origin);
    if (!(in.in < in.out) || !(origin.norm() >= solid.radius)) return;
    const Vec3 entry = origin + in.in * (to - origin);
    normal = round_normal(solid, entry, to, direction(entry));
  }
  if (length(Vec3(normal - outward)) < kRounding) return;
  if (!(length(to) < solid.radius) && !holds_behind(solid, normal, to)) return;
  const Polar<double> back = polar(Vec3(solid.radius * normal - to));
  if (!(back.length > 0.0)) return;
  seen.normal = back.direction;
  seen.height = patch.offset - back.length;
}

}  // namespace

PatchProxy patch_proxy(const LocalModel& model, std::uint16_t object, const Vec3& tool, double age,
                       const FeatureMemory& before, const CameFrom& from) noexcept {
  SeenPatches hollow, joined;
  for (const SurfacePatch& patch : model.view()) {
    if (patch.object != object) continue;
    const Height h = height_above(patch, age * patch.velocity, tool);
    const Vec3& undefined = before.feature != 0 ? before.normal : patch.normal;
    const Vec3 normal = h.normal.isZero(0.0) ? undefined : h.normal;
    const double then = age - from.elapsed;
    const double came =
        from.known ? height_above(patch, then * patch.velocity, from.position).height : 0.0;
    PatchView seen{&patch, h.height, normal, came};
    leave_behind(seen, age * patch.velocity, then * patch.velocity, tool, before, from);
    (patch.joined ? joined : hollow).add(seen);
  }
  const PatchProxy open = before_all(hollow, tool);
  const PatchProxy convex = behind_all(joined, tool, age, before, from.known);
  // All patches of an object are joined, or none is. If both kinds occur, the deeper contact
  // counts.
  return convex.surface.depth > open.surface.depth ? convex : open;
}

}  // namespace feltwire
