#pragma once
// The surface of a polyhedron as a graph in which three edges meet at each corner.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace feltwire {

/// A corner of the graph. Its three edges are in clockwise order, seen from outside. The walk round
/// a face, counter-clockwise, enters a corner by edge s and leaves it by edge (s + 1) % 3.
struct GraphCorner {
  std::array<std::uint16_t, 3> next;  // the corner at the other end of each edge
  std::array<std::uint8_t, 3> back;   // and which of that one's edges it is
  std::array<std::uint16_t, 3> face;  // face s lies between the edges s and (s + 1) % 3
  std::uint16_t vertex;
};

/// The graph of a closed surface with `vertices` vertices. Face f has the vertices loop[first[f]]
/// ... loop[first[f + 1] - 1], counter-clockwise seen from outside. Where n > 3 edges meet, n - 2
/// corners lie at the vertex, joined by edges of no length; where only two meet, two corners with
/// two edges, and between these a face of its own number: that of the vertex, after those of all
/// faces. Each directed edge must be in one face, its opposite in another.
std::vector<GraphCorner> corner_graph(std::size_t vertices, std::span<const std::uint32_t> first,
                                      std::span<const std::uint32_t> loop);

}  // namespace feltwire
