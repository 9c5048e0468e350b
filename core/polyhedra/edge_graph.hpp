#pragma once
// Helpers for the two classes that cut a graph of corners (ClippedPolyhedron, ClosestFaceCells):
// the ends of edges, which corners and edges a plane cuts, and how the places of removed corners
// are filled.

#include <cstddef>
#include <cstdint>
#include <span>

namespace feltwire {

/// The end of an edge: its corner, and which of the corner's edges it is.
using EdgeEnd = std::uint16_t;
inline constexpr std::size_t kMostEndCorners = 1U << 14;
constexpr EdgeEnd end_of(std::size_t corner, std::size_t slot) {
  return static_cast<EdgeEnd>(corner << 2 | slot);
}
constexpr std::size_t corner_of(EdgeEnd end) { return end >> 2; }
constexpr std::size_t slot_of(EdgeEnd end) { return end & 3; }

/// [m] A corner this little above a plane lies on it: rounding of coordinates of some metres.
inline constexpr double kOnPlane = 1e-14;

/// The first `count` corners that are above a plane, in ascending order, and how many these are.
/// There must be room for one more. No branch decides between corners: their order is that of
/// chance.
template <class Heights, class Corners>
std::size_t find_above(const Heights& height, std::size_t count, Corners& above) noexcept {
  std::size_t found = 0;
  for (std::size_t v = 0; v < count; ++v) {
    above[found] = static_cast<std::uint16_t>(v);
    found += height[v] > kOnPlane ? 1 : 0;
  }
  return found;
}

/// The edges that the plane cuts, by their ends above it, and how many these are. `links[v].next`:
/// the other end of each edge of corner v. There must be room for one more.
template <class Heights, class Links, class Ends>
std::size_t find_cut_edges(const Heights& height, std::span<const std::uint16_t> above,
                           const Links& links, Ends& edges) noexcept {
  std::size_t found = 0;
  for (const std::size_t v : above)
    for (std::size_t s = 0; s < links[v].next.size(); ++s) {
      edges[found] = end_of(v, s);
      found += height[corner_of(links[v].next[s])] > kOnPlane ? 0 : 1;
    }
  return found;
}

/// Fills the places of corners that are gone, in ascending order, with the last of all `count`
/// corners, by move(from, place). Returns how many are left.
template <class Move>
std::size_t fill_places(std::span<const std::uint16_t> gone, std::size_t count,
                        const Move& move) noexcept {
  std::size_t left = gone.size();  // to fill; those behind are beyond the end
  for (std::size_t k = 0; k < left; ++k) {
    while (left > k && gone[left - 1] == count - 1) {
      --left;
      --count;
    }
    if (k == left) break;
    --count;
    move(count, gone[k]);
  }
  return count;
}

}  // namespace feltwire
