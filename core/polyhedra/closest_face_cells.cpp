#include "core/polyhedra/closest_face_cells.hpp"

#include <algorithm>
#include <limits>
#include <span>

namespace feltwire {

/// Computes the heights of corners above a linear function, and returns the largest height. `count`
/// is a multiple of four. The arrays x, y, z, t are aligned to 32 bytes.
FELTWIRE_ALSO_AVX2 static double heights_above(const std::array<const double*, 4>& corners,
                                               std::size_t count, const LinearFunction& function,
                                               double* height) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto* x = reinterpret_cast<const Double4*>(corners[0]);
  const auto* y = reinterpret_cast<const Double4*>(corners[1]);
  const auto* z = reinterpret_cast<const Double4*>(corners[2]);
  const auto* t = reinterpret_cast<const Double4*>(corners[3]);
  auto* out = reinterpret_cast<Double4*>(height);
  Double4 most = {-kInfinity, -kInfinity, -kInfinity, -kInfinity};
  for (std::size_t i = 0; 4 * i < count; ++i) {
    const Double4 h =
        t[i] + (function.x * x[i] + function.y * y[i] + function.z * z[i] - function.offset);
    out[i] = h;
    most = h > most ? h : most;
  }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

ClosestFaceCells::ClosestFaceCells(const ClippedPolyhedron& whole, const Vec3& normal,
                                   double offset, std::size_t cell) noexcept
    : count_(whole.corner_count()) {
  static_assert(kCorners >= ClippedPolyhedron::kCorners);
  const auto tag = static_cast<Tag>(kCell + cell);
  for (std::size_t i = 0; i < count_; ++i) {
    const Vec3 at = whole.corner(i);
    x_[i] = at.x();
    y_[i] = at.y();
    z_[i] = at.z();
    t_[i] = offset - normal.dot(at);
    mirrored_[i] = 0;
    const auto& face = whole.tags(i);
    Links& links = links_[i];
    links.face = {face[0], face[1], face[2], tag};
    // Edge s lies on face s and on the previous face. It leaves the third face.
    for (std::size_t s = 0; s < 3; ++s) {
      const ClippedPolyhedron::Neighbour near = whole.neighbour(i, s);
      links.next[(s + 1) % 3] = end_of(near.corner, (near.slot + 1) % 3);
    }
    links.next[3] = kDown;
  }
  pad_corners();
}

void ClosestFaceCells::pad_corners() noexcept {
  for (Numbers* all : {&x_, &y_, &z_, &t_}) pad(*all, count_);
}

void ClosestFaceCells::insert(const Vec3& normal, double offset, std::size_t cell) noexcept {
  alignas(32) Numbers height;
  const LinearFunction function{normal.x(), normal.y(), normal.z(), offset};
  if (!(heights_above({x_.data(), y_.data(), z_.data(), t_.data()}, count_, function,
                      height.data()) > kOnPlane))
    return;
  height[kBelow] = -1.0;
  std::array<std::uint16_t, kCorners + 1> places;
  const std::span gone(places.data(), find_above(height, count_, places));
  std::array<EdgeEnd, 4 * kCorners + 1> edges;
  const std::span cuts(edges.data(), find_cut_edges(height, gone, links_, edges));
  if (count_ + cuts.size() > kCorners) [[unlikely]]
    return;
  const std::size_t old = count_;
  const auto tag = static_cast<Tag>(kCell + cell);
  for (const EdgeEnd edge : cuts) make(edge, tag, height);
  for (std::size_t k = 0; k < cuts.size(); ++k) join(old + k, cuts[k], old);
  count_ =
      fill_places(gone, count_, [&](std::size_t from, std::size_t place) { move(from, place); });
  pad_corners();
}

/// Makes a corner on the edge from a removed corner to a kept corner.
void ClosestFaceCells::make(EdgeEnd cut, Tag tag, const Numbers& height) noexcept {
  const std::size_t v = corner_of(cut), at = count_++;
  const EdgeEnd kept = links_[v].next[slot_of(cut)];
  const std::size_t u = corner_of(kept);
  std::size_t slot = slot_of(cut);
  Links& links = links_[at];
  if (u == kBelow) {  // The edge goes straight down.
    x_[at] = x_[v];
    y_[at] = y_[v];
    z_[at] = z_[v];
    t_[at] = t_[v] - height[v];
    links.face = links_[v].face;
    mirrored_[at] = mirrored_[v];
  } else {
    const double part = std::clamp(height[u] / (height[u] - height[v]), 0.0, 1.0);
    x_[at] = x_[u] + part * (x_[v] - x_[u]);
    y_[at] = y_[u] + part * (y_[v] - y_[u]);
    z_[at] = z_[u] + part * (z_[v] - z_[u]);
    t_[at] = t_[u] + part * (t_[v] - t_[u]);
    slot = slot_of(kept);
    links.face = links_[u].face;
    mirrored_[at] = mirrored_[u] ^ 1U;
    links_[u].next[slot] = end_of(at, slot);
  }
  links.face[slot] = tag;
  links.next = {kDown, kDown, kDown, kDown};
  links.next[slot] = kept;
  links_[v].next[slot_of(cut)] = end_of(at, slot);  // join() follows this link.
}

/// Connects a new corner to other new corners. For each connection, the function walks over removed
/// corners along a two-dimensional face. `from` is the start of the walk. `first` is the first new
/// corner.
void ClosestFaceCells::join(std::size_t made, EdgeEnd from, std::size_t first) noexcept {
  Links& links = links_[made];
  const std::size_t own = slot_of(links_[corner_of(from)].next[slot_of(from)]);
  for (std::size_t r = 0; r < 4; ++r) {
    if (r == own || links.next[r] != kDown) continue;
    // The new edge lies in the new cell and in these two cells.
    const std::size_t s = own != 0 && r != 0 ? 0 : own != 1 && r != 1 ? 1 : 2;
    const Tag p = links.face[s], q = links.face[6 - own - r - s];
    EdgeEnd at = from;
    do {
      const Links& gone = links_[corner_of(at)];
      at = gone.next[gone.onward(slot_of(at), p, q)];
    } while (corner_of(at) < first);
    const std::size_t other = corner_of(at), slot = links_[other].onward(slot_of(at), p, q);
    links.next[r] = end_of(other, slot);
    links_[other].next[slot] = end_of(made, r);
  }
}

void ClosestFaceCells::move(std::size_t from, std::size_t place) noexcept {
  for (Numbers* all : {&x_, &y_, &z_, &t_}) (*all)[place] = (*all)[from];
  mirrored_[place] = mirrored_[from];
  const Links& moved = links_[place] = links_[from];
  for (std::size_t s = 0; s < 4; ++s)
    if (moved.next[s] != kDown)
      links_[corner_of(moved.next[s])].next[slot_of(moved.next[s])] = end_of(place, s);
}

}  // namespace feltwire
