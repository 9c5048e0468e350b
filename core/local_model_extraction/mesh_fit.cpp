#include "core/local_model_extraction/mesh_fit.hpp"

#include <algorithm>
#include <limits>

#include "core/base/numeric.hpp"
#include "core/geometry/segment.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"

namespace feltwire {
namespace {

// Largest number of triangles to examine; with more triangles, the extent is halved.
constexpr std::size_t kMostLooked = 256;

/// Placement of a triangle relative to a patch.
struct TrianglePlacement {
  // True if any corner is in front of or behind the patch; both are false on the patch.
  bool front = false, behind = false;
  bool hidden = false;  // true if the whole triangle is behind the patch
};

/// Returns the placement of a triangle. Tests the corners and, because a patch may be curved, the
/// middle.
TrianglePlacement placement_of(const MeshFit& fit, const std::array<Vec3, 3>& corners,
                               double skin) {
  TrianglePlacement placement{.front = false, .behind = false, .hidden = true};
  // Between corners behind a hollow patch, a triangle may still be in front of the patch.
  const double longest =
      std::max({(corners[1] - corners[0]).squaredNorm(), (corners[2] - corners[1]).squaredNorm(),
                (corners[0] - corners[2]).squaredNorm()});
  const double bulge = std::max(0.0, -0.5 * fit.curvature) * longest;
  const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3.0;
  for (const Vec3& p : {corners[0], corners[1], corners[2], middle}) {
    const double height = fit.height(p),
                 may = kPatchSlope * (p - fit.point).norm() + fit.slack + skin;
    placement.front |= height > may;
    placement.behind |= height < -may;
    placement.hidden &= height < -(may + bulge);
  }
  return placement;
}

}  // namespace

bool MeshFits::join(const MeshFit& plane) {
  if (count_ == kMaxPatches) return false;
  for (int i = 0; i < count_; ++i) {
    const MeshFit& other = (*this)[i];
    const TrianglePlacement there = placement_of(other, corners(plane.triangle), surface_->skin());
    const TrianglePlacement here = placement_of(plane, corners(other.triangle), surface_->skin());
    const bool convex = there.behind && !there.front && !here.front;
    const bool hollow = there.front && !there.behind && !here.behind;
    if (!convex && !hollow) return false;
    if (count_ > 1 && convex != joined_) return false;
    joined_ = convex;
  }
  add(plane);
  return true;
}

MeshFits::Other MeshFits::first_other(const Vec3& place, double height, double extent) const {
  while (extent > surface_->skin()) {
    Other first{.distance = hypotenuse(height, extent), .looked = extent};
    std::size_t looked = 0;
    surface_->tree().within(
        place, [&] { return looked > kMostLooked ? 0.0 : first.distance; },
        [&](std::uint32_t t) {
          if (++looked > kMostLooked) return;
          Other other = beginning(t, place);
          if (!(other.distance < first.distance ||
                (other.distance == first.distance && other.triangle < first.triangle)))
            return;
          other.looked = extent;
          first = other;
        });
    if (looked <= kMostLooked) return first;
    extent *= 0.5;
  }
  return {.distance = height};
}

bool MeshFits::faces(const MeshFit& fit, const std::array<Vec3, 3>& c) const {
  const Vec3 normal = side_ * (c[1] - c[0]).cross(c[2] - c[0]);
  const Vec3 bent = fit.normal + fit.curvature * fit.way((c[0] + c[1] + c[2]) / 3.0);
  return normal.dot(bent) >= kFacing * normal.norm() * bent.norm();
}

MeshFits::Other MeshFits::beginning(std::uint32_t t, const Vec3& place) const {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const std::array<Vec3, 3> c = corners(t);
  std::array<TrianglePlacement, kMaxPatches> lies;
  bool all_hidden = true, any_hidden = false;
  for (int i = 0; i < count_; ++i) {
    const TrianglePlacement placement = lies[static_cast<std::size_t>(i)] =
        placement_of((*this)[i], c, surface_->skin());
    all_hidden &= placement.hidden;
    any_hidden |= placement.hidden;
  }
  // The tool cannot reach a triangle behind the patches.
  if (joined_ ? all_hidden : any_hidden) return {.distance = kNever};
  for (int i = 0; i < count_; ++i) {
    const TrianglePlacement& on = lies[static_cast<std::size_t>(i)];
    if (on.front || on.behind || !faces((*this)[i], c)) continue;
    bool whole = true;
    for (int j = 0; j < count_; ++j) {
      const TrianglePlacement& to = lies[static_cast<std::size_t>(j)];
      whole &= j == i || !(joined_ ? to.front : to.behind);
    }
    if (whole) return {.distance = border(t, c, place), .border = true};
  }
  return {.distance = (nearest_on_triangle(c, place).point - place).norm(), .triangle = t};
}

/// Returns the distance [m] from `place` to the nearest edge without a neighbour triangle.
double MeshFits::border(std::uint32_t t, const std::array<Vec3, 3>& c, const Vec3& place) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k)
    if (surface_->mesh().neighbour(t, static_cast<int>(k)) == TriangleMesh::kNone)
      least =
          std::min(least, (nearest_on_segment(c[k], c[(k + 1) % 3], place).point - place).norm());
  return least;
}

}  // namespace feltwire
