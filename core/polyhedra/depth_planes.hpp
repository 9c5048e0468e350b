#pragma once
// The planes that bound a solid's part, thickened away from a tool.

#include <array>

#include "core/polyhedra/depth_integrals.hpp"

namespace feltwire {

struct DepthPlane {
  Vec3 normal;    // outwards
  double offset;  // [m]
  bool inner;     // bounds the part but is no surface: depth is not measured to it
};

/// The planes of a part as add_depth() uses them.
class DepthPlanes {
 public:
  DepthPlanes(const SolidPart& part, const Vec3* away) noexcept;
  std::size_t size() const { return count_; }
  const DepthPlane& operator[](std::size_t i) const { return planes_[i]; }
  std::size_t facing() const { return facing_; }  // the surface most in the way of the tool

 private:
  void add(const HalfSpaceBelow& plane, bool inner) noexcept {
    if (count_ < planes_.size()) planes_[count_++] = {plane.normal, plane.offset, inner};
  }
  void add_all(const SolidPart& part, const Vec3* away) noexcept;
  void add_outline(const SolidPart& part, const Vec3& away) noexcept;

  std::array<DepthPlane, kMostDepthPlanes> planes_;
  std::size_t count_ = 0, facing_ = 0;
};

}  // namespace feltwire
