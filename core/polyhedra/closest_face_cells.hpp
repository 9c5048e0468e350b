#pragma once
// The cells of a convex polyhedron, in each of which another of some linear functions is the least.

#include <array>
#include <cstdint>

#include "core/polyhedra/clipped_polyhedron.hpp"

namespace feltwire {

/// The least of linear functions f(x) = offset - normal . x over a polyhedron is concave, so the
/// points (x, t) below it, t <= f(x), are a convex polyhedron in four dimensions. This is its
/// surface: a graph of corners, each on four faces, of which each is a face of the polyhedron or
/// the cell of a function. A function more is a cut, as in ClippedPolyhedron, one dimension up: it
/// looks only at signs of heights, removes corners, places new ones on the edges that led to them,
/// and joins these round each face of two dimensions that it has cut. So all cells are found
/// together, and what lies between two of them is computed once.
class ClosestFaceCells {
 public:
  using Tag = ClippedPolyhedron::Tag;
  /// The tag of cell k is kCell + k. The tags of the polyhedron's faces must be others.
  static constexpr Tag kCell = 0x800, kMostCells = 0x801;
  static_assert(kCell + kMostCells <= ClippedPolyhedron::kOwn);
  static constexpr std::size_t kCorners = 6144;

  /// All of a polyhedron, which may not be empty, is one cell.
  ClosestFaceCells(const ClippedPolyhedron& whole, const Vec3& normal, double offset,
                   std::size_t cell) noexcept;

  /// Adds a function. Leaves it out if there is no room for more corners. Changes nothing if it is
  /// nowhere the least.
  void insert(const Vec3& normal, double offset, std::size_t cell) noexcept;

  std::size_t corner_count() const { return count_; }
  Vec3 corner(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
  double least(std::size_t i) const { return t_[i]; }  // of the functions at a corner
  /// The tags of the four faces at a corner.
  const std::array<Tag, 4>& faces(std::size_t i) const { return links_[i].face; }
  /// The corner at the other end of the edge that leaves the face of this slot. None leaves a cell
  /// at a corner of the polyhedron itself.
  std::size_t beyond(std::size_t i, std::size_t slot) const {
    return corner_of(links_[i].next[slot]);
  }
  /// The other three slots, seen from within the cell of this one: round the face of the first one,
  /// counter-clockwise seen from outside of the cell, the next corner is that beyond the third.
  const std::array<std::uint8_t, 3>& around(std::size_t i, std::size_t slot) const {
    return kAround[mirrored_[i]][slot];
  }

 private:
  /// The end of all edges that lead down: no corner. It is never above a function.
  static constexpr std::size_t kBelow = kCorners;
  static_assert(kBelow < kMostEndCorners);
  static constexpr EdgeEnd kDown = end_of(kBelow, 3);
  static constexpr std::array<std::array<std::array<std::uint8_t, 3>, 4>, 2> kAround = {
      {{{{2, 1, 3}, {0, 2, 3}, {1, 0, 3}, {0, 1, 2}}},
       {{{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {1, 0, 2}}}}};

  struct Links {
    std::array<EdgeEnd, 4> next;  // the other end of each edge; edges have the number of
    std::array<Tag, 4> face;      // the face that they leave
    std::size_t slot(Tag tag) const {
      return (face[1] == tag ? 1U : 0U) + (face[2] == tag ? 2U : 0U) + (face[3] == tag ? 3U : 0U);
    }
    /// The slot of the edge that goes on round the face of two dimensions in both p and q, for a
    /// walk that came by the edge of slot `by`.
    std::size_t onward(std::size_t by, Tag p, Tag q) const { return 6 - by - slot(p) - slot(q); }
  };
  using Numbers = PaddedNumbers<kCorners>;

  void pad_corners() noexcept;
  void make(EdgeEnd cut, Tag tag, const Numbers& height) noexcept;
  void join(std::size_t made, EdgeEnd from, std::size_t first) noexcept;
  void move(std::size_t from, std::size_t place) noexcept;

  alignas(32) Numbers x_;
  alignas(32) Numbers y_;
  alignas(32) Numbers z_;
  alignas(32) Numbers t_;
  std::array<Links, kCorners> links_;
  std::array<std::uint8_t, kCorners> mirrored_;  // the sense of the slots' order
  std::size_t count_ = 0;
};

}  // namespace feltwire
