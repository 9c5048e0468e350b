#pragma once
// A scene near one tool, as few surfaces: what a server sends instead of a force alone, and a
// client renders at its own servo rate (Adachi et al. 1995; Mark et al. 1996).

#include <array>
#include <cstdint>
#include <span>

#include "core/base/types.hpp"
#include "core/material/material.hpp"

namespace feltwire {

/// One surface about the point of it that is nearest to the tool. World frame.
struct SurfacePatch {
  Vec3 point = Vec3::Zero();    // [m] on the surface
  Vec3 normal = Vec3::UnitZ();  // unit, towards the free side
  /// [1/m] of the surface at the point: > 0 where the solid bulges towards the free side (a ball
  /// felt from outside), < 0 where the free side is the hollow one, 0: plane.
  double curvature = 0.0;
  Vec3 axis = Vec3::Zero();  // unit: the surface is straight along it; zero: curved alike all ways
  Vec3 velocity = Vec3::Zero();  // [m/s] of the surface
  double radius = 0.0;           // [m] about the point: beyond it the surface may be another
  /// [m] So far in front of it what pushes a tool stands: the radius of a tool that is a ball (by
  /// which convex edges are round), less the mean depth of a texture.
  double offset = 0.0;
  Material material;
  // Stick point, where the tool touches this surface.
  Vec3 anchor = Vec3::Zero();  // [m]
  bool touching = false, slipping = false;
  // Which surface this is, the same from one model to the next.
  std::uint16_t object = 0;
  std::uint32_t feature = 0;  // as FeatureMemory has it: no two surfaces of an object share one
  /// The solid is only where the tool is behind all joined patches of this object (a convex edge or
  /// corner), and pushes along the one it was entered by, or beyond an obtuse edge by the next;
  /// patches that are not joined are solids of their own, and push to the nearest place in front of
  /// all. Either way an object is one contact with one stick point.
  bool joined = false;
  bool faceted = false;  // cut into facets: the stick point turns with the normal, see carried()
  bool rough = false;    // a texture is on it: what the reply's force has beside the patches
};

inline constexpr int kMaxPatches = 3;

/// All surfaces within `reach` of `center`, if no more than kMaxPatches are; `reach` ends before
/// another would begin.
struct LocalModel {
  /// Counts the scenes that the session has been in: what a reload brings shares no surface with
  /// what was before, whatever its objects and features are called.
  std::uint32_t scene = 0;
  Vec3 center = Vec3::Zero();  // [m] the tool position that it was made for
  double reach = 0.0;          // [m] 0: the model says nothing
  std::array<SurfacePatch, kMaxPatches> patches{};
  int count = 0;
  std::span<const SurfacePatch> view() const {
    return {patches.data(), static_cast<std::size_t>(count)};
  }
};

}  // namespace feltwire
