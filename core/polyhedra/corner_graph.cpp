#include "core/polyhedra/corner_graph.hpp"

#include <map>
#include <utility>

namespace feltwire {
namespace {

using Ends = std::pair<std::uint32_t, std::uint32_t>;

/// A neighbour of a vertex, and the face between this neighbour and the next neighbour in the ring.
struct Spoke {
  std::uint32_t to;
  std::uint16_t face;
};

/// Returns the neighbours of each vertex, clockwise as seen from outside.
std::vector<std::vector<Spoke>> rings(std::size_t vertices, std::span<const std::uint32_t> first,
                                      std::span<const std::uint32_t> loop) {
  // For consecutive vertices u, v, w of a face, maps (v, u) to w and the face.
  std::map<Ends, Spoke> after;
  for (std::size_t f = 0; f + 1 < first.size(); ++f) {
    const std::size_t begin = first[f], count = first[f + 1] - begin;
    for (std::size_t k = 0; k < count; ++k)
      after[{loop[begin + (k + 1) % count], loop[begin + k]}] = {loop[begin + (k + 2) % count],
                                                                 static_cast<std::uint16_t>(f)};
  }
  std::vector<std::vector<Spoke>> around(vertices);
  for (const auto& [at, w] : after) {
    auto& ring = around[at.first];
    if (!ring.empty()) continue;
    std::uint32_t u = at.second;
    do {
      const Spoke& next = after.at({at.first, u});
      ring.push_back({u, next.face});
      u = next.to;
    } while (u != at.second);
  }
  return around;
}

struct Slot {
  std::uint16_t corner;
  std::uint8_t edge;
};

}  // namespace

std::vector<GraphCorner> corner_graph(std::size_t vertices, std::span<const std::uint32_t> first,
                                      std::span<const std::uint32_t> loop) {
  std::vector<GraphCorner> graph;
  std::map<Ends, Slot> slots;
  const auto join = [&](Slot a, Slot b) {
    graph[a.corner].next[a.edge] = b.corner;
    graph[a.corner].back[a.edge] = b.edge;
    graph[b.corner].next[b.edge] = a.corner;
    graph[b.corner].back[b.edge] = a.edge;
  };
  const auto add = [&](std::uint32_t v, std::size_t a, std::size_t b, std::size_t c) {
    const auto number = [](std::size_t face) { return static_cast<std::uint16_t>(face); };
    graph.push_back({{}, {}, {number(a), number(b), number(c)}, static_cast<std::uint16_t>(v)});
    return static_cast<std::uint16_t>(graph.size() - 1);
  };
  const auto around = rings(vertices, first, loop);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const auto& ring = around[v];
    const std::size_t count = ring.size();
    if (count < 2) continue;
    if (count == 2) {  // A face of two edges lies between the two corners.
      const std::size_t between = first.size() - 1 + v;
      const std::uint16_t a = add(v, ring[0].face, between, ring[1].face);
      const std::uint16_t b = add(v, ring[1].face, between, ring[0].face);
      slots[{v, ring[0].to}] = {a, 0};
      slots[{v, ring[1].to}] = {b, 0};
      join({a, 1}, {b, 2});
      join({a, 2}, {b, 1});
      continue;
    }
    const std::uint16_t closing = ring[count - 1].face;
    std::uint16_t last = add(v, ring[0].face, ring[1].face, closing);
    slots[{v, ring[0].to}] = {last, 0};
    slots[{v, ring[1].to}] = {last, 1};
    for (std::size_t i = 2; i + 1 < count; ++i) {
      const std::uint16_t corner = add(v, ring[i - 1].face, ring[i].face, closing);
      join({last, 2}, {corner, 0});
      slots[{v, ring[i].to}] = {corner, 1};
      last = corner;
    }
    slots[{v, ring[count - 1].to}] = {last, 2};
  }
  for (const auto& [ends, slot] : slots) join(slot, slots.at({ends.second, ends.first}));
  return graph;
}

}  // namespace feltwire
