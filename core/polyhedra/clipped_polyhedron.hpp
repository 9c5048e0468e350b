#pragma once
// A convex polyhedron that is cut by planes, without memory from the heap.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "core/polyhedra/edge_graph.hpp"
#include "core/polyhedra/polyhedron.hpp"
#include "core/polyhedra/simd4.hpp"

namespace feltwire {

/// The part of a polyhedron below planes, as a graph of corners at which three edges meet (Powell &
/// Abel 2015, An exact general remeshing scheme applied to physically conservative voxelization).
/// A cut looks only at signs of heights: it removes corners, places new ones on the edges that led
/// to them, and joins these round each face. So the surface stays closed whatever rounding does to
/// a corner on a plane, and integrals over it by the divergence theorem are right to rounding.
class ClippedPolyhedron {
 public:
  static constexpr std::size_t kCorners = 3072;
  using Tag = std::uint16_t;
  /// The tag of face f of the polyhedron itself is kOwn + f. Cuts have lower ones.
  static constexpr Tag kOwn = 0x1010;

  ClippedPolyhedron() = default;
  // Only what is in use is copied.
  ClippedPolyhedron(const ClippedPolyhedron& other) noexcept { *this = other; }
  ClippedPolyhedron& operator=(const ClippedPolyhedron& other) noexcept;

  /// The whole solid, placed at rotation * p + position.
  void assign(const Polyhedron& solid, const Mat3& rotation, const Vec3& position) noexcept;

  /// Keeps the points x with normal . x <= offset; the normal has any length but zero. The face
  /// that the cut makes gets the tag. Returns false if nothing with a volume is left. Without room
  /// for more corners the cut is left out. Where no corner is above the plane, all stays the same.
  bool cut(const Vec3& normal, double offset, Tag tag) noexcept;

  bool empty() const { return count_ == 0; }
  std::size_t corner_count() const { return count_; }
  /// [m] The lowest and the highest corner above a plane, times the length of its normal. Without
  /// corners infinity, and minus infinity.
  struct Extent {
    double least, most;
  };
  Extent extent(const Vec3& normal, double offset) const noexcept;
  Vec3 middle() const noexcept { return {x().mean(), y().mean(), z().mean()}; }  // of the corners
  Vec3 corner(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
  /// [m] Coordinates of all corners. Several may lie at one place.
  using Coordinates = Eigen::Map<const Eigen::ArrayXd, Eigen::Aligned16>;
  Coordinates x() const { return coordinates(x_); }
  Coordinates y() const { return coordinates(y_); }
  Coordinates z() const { return coordinates(z_); }
  /// The tags of the three faces at a corner: face s lies between the edges s and (s + 1) % 3.
  const std::array<Tag, 3>& tags(std::size_t i) const { return links_[i].face; }
  /// The other end of edge s of a corner, and which of its edges it is there.
  struct Neighbour {
    std::size_t corner, slot;
  };
  Neighbour neighbour(std::size_t i, std::size_t s) const {
    return {corner_of(links_[i].next[s]), slot_of(links_[i].next[s])};
  }

 private:
  static_assert(kCorners <= kMostEndCorners);
  struct Links {
    std::array<EdgeEnd, 3> next;  // the other end of each edge, in the order of GraphCorner
    std::array<Tag, 3> face;      // the tag of the face whose walk enters by the edge
  };
  static constexpr std::array<std::uint8_t, 3> kAfter = {1, 2, 0};
  /// The next end at which the walk round a face, counter-clockwise, enters a corner.
  EdgeEnd walked(EdgeEnd entered) const {
    return links_[corner_of(entered)].next[kAfter[slot_of(entered)]];
  }

  Coordinates coordinates(const auto& values) const {
    return {values.data(), static_cast<Eigen::Index>(count_)};
  }
  using Numbers = PaddedNumbers<kCorners>;
  /// The extent, and the heights of all corners.
  Extent heights(const Vec3& normal, double offset, Numbers& height) const noexcept;
  void pad_corners() noexcept;
  /// Joins the corners that a cut has made, round each face that it has cut. `height`: above zero
  /// for those.
  void close(std::span<const std::uint16_t> made, const Numbers& height) noexcept;
  void move(std::size_t from, std::size_t place) noexcept;

  alignas(32) Numbers x_;
  alignas(32) Numbers y_;
  alignas(32) Numbers z_;
  std::array<Links, kCorners> links_;
  std::size_t count_ = 0;
};

}  // namespace feltwire
