#include "core/geometry/torus.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/geometry/local_curvature.hpp"
#include "core/geometry/revolution.hpp"
#include "core/geometry/round_proxy.hpp"
#include "core/geometry/solid_proxy.hpp"
#include "core/geometry/surface_parts.hpp"

namespace feltwire {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Returns the unit vector from the axis to p, or zero on the axis.
Vec3 facing_of(const Vec3& p) { return direction(Vec3(p.x(), p.y(), 0.0)); }

/// Returns the coordinates of p in the cross-section of the ring at `facing`: x outwards from the
/// centre of the tube, y upwards.
Vec3 in_cut(const Torus& torus, const Vec3& facing, const Vec3& p) {
  return {facing.dot(p) - torus.major_radius, p.z(), 0.0};
}
Vec3 from_cut(const Vec3& facing, const Vec3& way) {
  return way.x() * facing + way.y() * Vec3::UnitZ();
}

Vec3 core_of(const Torus& torus, const Vec3& p) {
  return torus.major_radius * or_else(facing_of(p), Vec3::UnitX());
}

double distance_to(const Torus& torus, const Vec3& p) {
  return length(Vec3(p - core_of(torus, p))) - torus.minor_radius;
}

/// Returns the distance [m] from a free point to the first entry of a path into the ring, or
/// infinity. The path is `length` [m] long, in the unit direction `along`. Each step along the path
/// is as long as the distance to the ring, but at least 1/64 of the tube's radius. So a step can
/// miss only a chord that is shorter than this.
double way_in(const Torus& torus, const Vec3& from, const Vec3& along, double length) {
  constexpr double kLeastStep = 1.0 / 64.0;
  constexpr int kMostSteps = 1024, kHalvings = 48;
  double before = 0.0, at = 0.0;
  for (int step = 0; step < kMostSteps; ++step) {
    const double off = distance_to(torus, from + at * along);
    if (off <= 0.0) {
      for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (before + at);
        (distance_to(torus, from + middle * along) <= 0.0 ? at : before) = middle;
      }
      return at;
    }
    if (!(at < length)) break;
    before = at;
    at = std::min(length, at + std::max(off, kLeastStep * torus.minor_radius));
  }
  return kInfinite;
}

/// The proxy on the ring: its cross-section and the normal in it. Around the axis, the proxy moves
/// as on a cylinder with the ring's radius. Around the tube, it moves as on a cylinder with the
/// tube's radius. In the hole, the nearest cross-section changes with the slightest movement, so
/// the proxy stays in its cross-section there.
struct RingProxy {
  Vec3 facing, normal;  // direction of the cross-section; normal within it
};

/// memory.triangle is zero while the proxy is in the cross-section nearest to the tool. Otherwise
/// it is the angle of the proxy's cross-section, in units of 2^-32 turns.
constexpr double kTurn = 2.0 * std::numbers::pi, kParts = 0x1p32;
Vec3 remembered_facing(const FeatureMemory& memory) {
  if (memory.triangle == 0) return or_else(facing_of(memory.proxy), Vec3::UnitX());
  const double angle = kTurn / kParts * memory.triangle;
  return {std::cos(angle), std::sin(angle), 0.0};
}
std::uint32_t part_of(const Vec3& facing) {
  const double turns = std::atan2(facing.y(), facing.x()) / kTurn;
  const double part = std::round(kParts * (turns < 0.0 ? turns + 1.0 : turns));
  return static_cast<std::uint32_t>(std::clamp(part, 1.0, kParts - 1.0));
}

RingProxy followed(const Torus& torus, const Vec3& from, const Vec3& to, RingProxy proxy) {
  const Vec3 before = in_cut(torus, proxy.facing, from);
  proxy.facing = round_normal(RoundSolid{torus.major_radius, kInfinite}, from, to, proxy.facing);
  proxy.normal = round_normal(RoundSolid{torus.minor_radius, kInfinite}, before,
                              in_cut(torus, proxy.facing, to), proxy.normal);
  return proxy;
}

/// Moves a proxy beyond the axis onto the axis, and then returns true. A tube that is wider than
/// the ring (possible for a ball tool) ends on the axis.
bool ends_on_axis(const Torus& torus, RingProxy& proxy) {
  const double big = torus.major_radius, small = torus.minor_radius;
  if (!(big + small * proxy.normal.x() < 0.0)) return false;
  const double up = std::sqrt(small * small - big * big);
  proxy.normal = Vec3(-big, std::copysign(up, proxy.normal.y()), 0.0) / small;
  return true;
}

SurfacePoint held_on_ring(const Torus& torus, const Vec3& p, RingProxy proxy,
                          FeatureMemory& memory) {
  const Vec3 offset = in_cut(torus, proxy.facing, p);
  const bool at_nearest = proxy.facing == facing_of(p);
  const bool nearest = at_nearest && proxy.normal == direction(offset);
  const bool inside = distance_to(torus, p) < 0.0;
  if (nearest && !inside) return free_at(p, memory);
  const Vec3 straight = from_cut(proxy.facing, proxy.normal);
  const bool on_tube = !ends_on_axis(torus, proxy);
  const Vec3 point =
      torus.major_radius * proxy.facing + torus.minor_radius * from_cut(proxy.facing, proxy.normal);
  // A tool that has left the ring is still in contact if the straight line from the tool to the
  // proxy crosses the ring.
  if (!inside) {
    const double back = straight.dot(point - p);
    if (!(back > 0.0) || !(way_in(torus, p, straight, back) < back)) return free_at(p, memory);
  }
  const Vec3 normal = from_cut(proxy.facing, proxy.normal);
  SurfacePoint on{point, normal, torus.minor_radius - length(offset)};
  if (!nearest || !on_tube) {
    const Polar<double> back = polar(Vec3(point - p));
    on.depth = back.length;
    if (back.length > 0.0) on.normal = back.direction;
  }
  held_on({point, normal, on.depth}, 0, memory);
  memory.proxy = p;  // For a round surface, the memory stores the tool's position.
  memory.triangle = at_nearest ? 0 : part_of(proxy.facing);
  return on;
}

/// Returns the extent [m] about a point of the surface within which a ball or a cylinder
/// approximates the ring with the tolerance kPatchSlope. The error grows with the neglected
/// curvature and with the change of curvature. `cosine` is the cosine of the angle between the
/// normal and the ring's plane.
double patch_extent(const Torus& torus, double cosine) {
  const double big = torus.major_radius, small = torus.minor_radius;
  const double across = big + small * cosine;  // [m] distance of the point from the axis
  const double left_out = std::min(1.0 / small, std::abs(cosine) / across);
  constexpr double kOfChange = 1.0 / 7.0, kOfTube = 0.25;
  return std::min(
      {1.5 * kPatchSlope / left_out, kOfChange * across * std::sqrt(small / big), kOfTube * small});
}

}  // namespace

SurfacePoint Torus::surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept {
  if (side == Side::inside) return hollow_surface(p, core_of(*this, p), minor_radius, memory);
  if (memory.feature != 0) {
    const Vec3 facing = remembered_facing(memory);
    const Vec3 normal = direction(Vec3(memory.normal.dot(facing), memory.normal.z(), 0.0));
    return held_on_ring(*this, p,
                        followed(*this, memory.proxy, p, {facing, or_else(normal, Vec3::UnitY())}),
                        memory);
  }
  const double off = distance_to(*this, p);
  const Vec3 way = p - memory.proxy;
  if (memory.tracked && !cannot_have_met(off, way)) {
    const Polar<double> along = polar(way);
    const double in = way_in(*this, memory.proxy, along.direction, along.length);
    if (in < kInfinite) {
      const Vec3 entry = memory.proxy + in * along.direction;
      const Vec3 facing = or_else(facing_of(entry), Vec3::UnitX());
      const Vec3 normal = direction(in_cut(*this, facing, entry));
      return held_on_ring(
          *this, p, followed(*this, entry, p, {facing, or_else(normal, Vec3::UnitY())}), memory);
    }
  }
  if (!(off < 0.0)) return free_at(p, memory);
  const Vec3 facing = or_else(facing_of(p), Vec3::UnitX());
  const Vec3 normal = direction(in_cut(*this, facing, p));
  return held_on_ring(*this, p, {facing, or_else(normal, Vec3::UnitY())}, memory);
}

Grown<Torus> Torus::grown(Side side, double ball) const noexcept {
  return {{major_radius, minor_radius + outward_sign(side) * ball}};
}

double Torus::room() const noexcept { return minor_radius; }

FieldPoint Torus::signed_distance(const Vec3& p) const noexcept {
  return round_distance(core_of(*this, p), minor_radius, p, Vec3::UnitZ());
}

Vec3 Torus::half_box() const noexcept {
  return {major_radius + minor_radius, major_radius + minor_radius, minor_radius};
}

double Torus::reach() const noexcept { return major_radius + minor_radius; }

MassProperties Torus::mass_properties() const {
  const double big = major_radius * major_radius, small = minor_radius * minor_radius;
  const double volume = 2.0 * std::numbers::pi * std::numbers::pi * major_radius * small;
  return {volume, Vec3::Zero(),
          volume * inertia_about_z(0.5 * big + 0.625 * small, big + 0.75 * small)};
}

TriangleSoup Torus::triangles(int segments) const {
  TriangleSoup soup;
  const auto around = static_cast<std::uint32_t>(segments);
  const auto tube = std::max<std::uint32_t>(3, around / 2);
  const auto turn = [](std::uint32_t i, std::uint32_t of) {
    const double angle = 2.0 * std::numbers::pi * i / of;
    return Vec3(std::cos(angle), std::sin(angle), 0.0);
  };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t k = 0; k < tube; ++k)
      soup.vertices.push_back(major_radius * turn(i, around) +
                              minor_radius * from_cut(turn(i, around), turn(k, tube)));
  const auto at = [&](std::uint32_t i, std::uint32_t k) { return i % around * tube + k % tube; };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t k = 0; k < tube; ++k) {
      soup.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
      soup.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  return soup;
}

/// Returns capsules along the edges of a polygon around the ring. The corners lie as far outside
/// the ring's circle as the middles of the edges lie inside.
std::vector<PhysicsGeom> Torus::geoms(Side side) const {
  if (side == Side::inside) return {};
  constexpr int kCapsules = 24;
  constexpr double kHalf = std::numbers::pi / kCapsules;
  const double corner = 2.0 * major_radius / (1.0 + std::cos(kHalf));
  std::vector<PhysicsGeom> ring;
  for (int i = 0; i < kCapsules; ++i) {
    const double angle = 2.0 * kHalf * i;
    const Vec3 facing(std::cos(angle), std::sin(angle), 0.0);
    ring.push_back({.kind = PhysicsGeom::Kind::capsule,
                    .size = {minor_radius, corner * std::sin(kHalf), 0.0},
                    .pose = Pose{corner * std::cos(kHalf) * facing,
                                 turn_to(Vec3::UnitZ(), Vec3::UnitZ().cross(facing))}});
  }
  return ring;
}

/// Returns the parts of the surface near p. The surface is smooth, but needs more than one patch.
/// Only the nearest patch is modelled, within the extent in which it approximates the ring.
SurfaceParts Torus::parts(Side side, const Vec3& p, std::uint32_t entered) const noexcept {
  SurfaceParts all;
  const Vec3 offset = p - core_of(*this, p);
  const double distance = length(offset);
  const Vec3 facing = or_else(facing_of(p), Vec3::UnitX());
  const double cosine = facing.dot(direction(offset));
  const double extent = patch_extent(*this, cosine);
  const double off = height(side, distance, minor_radius), near = std::max(0.0, off);
  add(all, unless_entered(near, side, entered), kOnlyFeature);
  double rest = extent - std::abs(off);
  if (side == Side::inside) {
    rest = std::max(near, rest);
  } else if (off > 0.0) {
    // Consider the ball in the hole that touches the ring at its point nearest to p and has its
    // centre on the axis. No surface is inside this ball. So a surface beyond the extent has at
    // least the distance `rest` from p.
    const double across = major_radius + minor_radius * cosine;
    const double bent = cosine < 0.0 ? off * -cosine / across : 0.0;
    rest = root(off, extent * std::sqrt(std::max(0.0, 1.0 - bent)));
  }
  add(all, std::max(0.0, rest), kOnlyFeature, false);
  return all;
}

PatchGeometry Torus::patch(Side side, const Vec3& p, int face, const FeatureMemory& memory,
                           bool touching) const noexcept {
  Vec3 facing = or_else(facing_of(p), Vec3::UnitX());
  Vec3 outward = or_else(direction(Vec3(p - major_radius * facing)), memory.normal);
  if (const Vec3* behind = left_behind(side, face, outward, memory, touching)) {
    outward = *behind;
    facing = remembered_facing(memory);
  }
  const double sign = outward_sign(side);
  const double cosine = facing.dot(outward), across = major_radius + minor_radius * cosine;
  const Vec3 round = Vec3::UnitZ().cross(facing);
  PatchGeometry s{.point = major_radius * facing + minor_radius * outward,
                  .normal = sign * outward};
  if (!(across > 0.0)) return s;
  const LocalCurvature like = local_curvature(round.cross(outward), round, sign / minor_radius, 0.0,
                                              sign * cosine / across);
  s.curvature = like.curvature;
  s.axis = like.axis;
  return s;
}

}  // namespace feltwire
