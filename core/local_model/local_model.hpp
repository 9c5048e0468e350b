#pragma once
// A local model: the surfaces of a scene near one tool. The server sends it besides the force, and
// the client renders it at its own servo rate (Adachi et al. 1995; Mark et al. 1996).

#include <array>
#include <cstdint>
#include <span>

#include "core/base/types.hpp"
#include "core/material/material.hpp"

namespace feltwire {

/// A surface, described around its point nearest to the tool. World frame.
struct SurfacePatch {
  Vec3 point = Vec3::Zero();    // [m] on the surface
  Vec3 normal = Vec3::UnitZ();  // unit, towards the free side
  /// [1/m] of the surface at the point. > 0: the solid is convex there (a ball felt from outside).
  /// < 0: the solid is hollow there (a ball felt from inside). 0: plane.
  double curvature = 0.0;
  Vec3 axis = Vec3::Zero();  // unit: the surface is straight along it; zero: same curve all ways
  Vec3 velocity = Vec3::Zero();  // [m/s] of the surface
  double radius = 0.0;           // [m] the patch is valid within this distance of the point
  /// [m] The surface that pushes the tool lies this far in front of the patch: the radius of a tool
  /// that is a ball (it also rounds convex edges), less the mean depth of a texture. Of a solid
  /// that keeps its kind when it grows by a ball the patch is of the grown one, and this is zero.
  double offset = 0.0;
  Material material;
  // The state of friction, if the tool touches this surface.
  Vec3 anchor = Vec3::Zero();  // [m] the stick point
  bool touching = false, slipping = false;
  // The identity of the surface, the same from one model to the next.
  std::uint16_t object = 0;
  std::uint32_t feature = 0;  // as in FeatureMemory; each surface of an object has its own
  /// Joined patches of an object bound one convex solid (an edge or a corner): the tool is inside
  /// only if it is behind all of them. It is pushed along the patch by which it entered, or by the
  /// next one beyond an obtuse edge. Patches that are not joined are separate solids: the tool is
  /// pushed to the nearest place in front of all of them. In both cases an object is one contact
  /// with one stick point.
  bool joined = false;
  bool faceted = false;  // made of facets: the stick point turns with the normal, see carried()
  bool rough = false;    // has a texture, whose force is only in the reply and not in the patches
  /// The receiver has this object's whole surface (prefetched_geometry.hpp). The patch marks where
  /// the server's proxy stands, or the nearest point. Its radius, curvature and offset say nothing.
  bool whole = false;
};

inline constexpr int kMaxPatches = 3;

/// All surfaces within `reach` of `center`. There are at most kMaxPatches: `reach` ends where the
/// next surface would begin.
struct LocalModel {
  /// Counts the scenes of the session. After a reload no surface is the same as before, even if its
  /// object and feature have the same numbers.
  std::uint32_t scene = 0;
  /// The version of the whole surfaces that the patches mean (PrefetchedSurfaces::version()); 0:
  /// there is no such patch.
  std::uint32_t surfaces = 0;
  Vec3 center = Vec3::Zero();  // [m] the tool position that it was made for
  double reach = 0.0;          // [m] 0: the model is empty
  std::array<SurfacePatch, kMaxPatches> patches{};
  int count = 0;
  std::span<const SurfacePatch> view() const {
    return {patches.data(), static_cast<std::size_t>(count)};
  }
};

}  // namespace feltwire
