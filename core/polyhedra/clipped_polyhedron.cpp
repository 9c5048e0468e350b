#include "core/polyhedra/clipped_polyhedron.hpp"

#include <algorithm>
#include <limits>

namespace feltwire {

/// Computes the heights of corners above a plane. `count` is a multiple of four, and all arrays are
/// aligned to 32 bytes.
FELTWIRE_ALSO_AVX2 static void compute_heights(const std::array<const double*, 3>& corners,
                                               std::size_t count, const LinearFunction& plane,
                                               double* height, ClippedPolyhedron::Extent& reach) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto* x = reinterpret_cast<const Double4*>(corners[0]);
  const auto* y = reinterpret_cast<const Double4*>(corners[1]);
  const auto* z = reinterpret_cast<const Double4*>(corners[2]);
  auto* out = reinterpret_cast<Double4*>(height);
  Double4 least = {kInfinity, kInfinity, kInfinity, kInfinity}, most = -least;
  for (std::size_t i = 0; 4 * i < count; ++i) {
    const Double4 h = plane.x * x[i] + plane.y * y[i] + plane.z * z[i] - plane.offset;
    out[i] = h;
    least = h < least ? h : least;
    most = h > most ? h : most;
  }
  reach = {std::min(std::min(least[0], least[1]), std::min(least[2], least[3])),
           std::max(std::max(most[0], most[1]), std::max(most[2], most[3]))};
}

ClippedPolyhedron& ClippedPolyhedron::operator=(const ClippedPolyhedron& other) noexcept {
  if (this == &other) return *this;
  count_ = other.count_;
  const std::size_t padded = (count_ + kSimdLanes - 1) / kSimdLanes * kSimdLanes;
  std::copy_n(other.x_.begin(), padded, x_.begin());
  std::copy_n(other.y_.begin(), padded, y_.begin());
  std::copy_n(other.z_.begin(), padded, z_.begin());
  std::copy_n(other.links_.begin(), count_, links_.begin());
  return *this;
}

void ClippedPolyhedron::assign(const Polyhedron& solid, const Mat3& rotation,
                               const Vec3& position) noexcept {
  count_ = 0;
  std::array<Vec3, kMostPolyhedronVertices> placed;
  if (solid.graph.size() > kCorners || solid.vertices.size() > placed.size()) [[unlikely]]
    return;  // polyhedron() limits the vertices and corners.
  for (std::size_t v = 0; v < solid.vertices.size(); ++v)
    placed[v] = rotation * solid.vertices[v] + position;
  for (const GraphCorner& corner : solid.graph) {
    const Vec3& at = placed[corner.vertex];
    x_[count_] = at.x();
    y_[count_] = at.y();
    z_[count_] = at.z();
    Links& links = links_[count_++];
    for (std::size_t s = 0; s < 3; ++s) links.next[s] = end_of(corner.next[s], corner.back[s]);
    for (std::size_t s = 0; s < 3; ++s) links.face[s] = static_cast<Tag>(kOwn + corner.face[s]);
  }
  pad_corners();
}

void ClippedPolyhedron::pad_corners() noexcept {
  for (Numbers* all : {&x_, &y_, &z_}) pad(*all, count_);
}

ClippedPolyhedron::Extent ClippedPolyhedron::heights(const Vec3& normal, double offset,
                                                     Numbers& height) const noexcept {
  const LinearFunction plane{normal.x(), normal.y(), normal.z(), offset};
  Extent reach{};
  compute_heights({x_.data(), y_.data(), z_.data()}, count_, plane, height.data(), reach);
  return reach;
}

ClippedPolyhedron::Extent ClippedPolyhedron::extent(const Vec3& normal,
                                                    double offset) const noexcept {
  alignas(32) Numbers height;
  return heights(normal, offset, height);
}

bool ClippedPolyhedron::cut(const Vec3& normal, double offset, Tag tag) noexcept {
  if (count_ == 0) return false;
  alignas(32) Numbers height;
  const Extent reach = heights(normal, offset, height);
  if (!(reach.most > kOnPlane)) return true;
  if (reach.least >= -kOnPlane) {
    count_ = 0;
    return false;
  }
  std::array<std::uint16_t, kCorners + 1> places;
  const std::span above(places.data(), find_above(height, count_, places));
  std::array<EdgeEnd, 3 * kCorners + 1> edges;
  const std::size_t count = find_cut_edges(height, above, links_, edges);
  if (count_ - above.size() + count > kCorners) [[unlikely]]
    return true;
  struct Corner {
    double x, y, z;
    EdgeEnd in;
  };
  std::array<Corner, kCorners> corners;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = corner_of(edges[i]);
    const EdgeEnd end = links_[v].next[slot_of(edges[i])];
    const std::size_t in = corner_of(end);
    const double part = std::clamp(height[in] / (height[in] - height[v]), 0.0, 1.0);
    corners[i] = {x_[in] + part * (x_[v] - x_[in]), y_[in] + part * (y_[v] - y_[in]),
                  z_[in] + part * (z_[v] - z_[in]), end};
  }
  // A new corner takes the place of a removed corner. At the new corner, the new face lies between
  // the other two edges.
  std::array<std::uint16_t, kCorners> made;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i < above.size() ? above[i] : count_++;
    const Corner& corner = corners[i];
    const std::size_t slot = slot_of(corner.in);
    Links& kept = links_[corner_of(corner.in)];
    made[i] = static_cast<std::uint16_t>(at);
    x_[at] = corner.x;
    y_[at] = corner.y;
    z_[at] = corner.z;
    links_[at] = {{corner.in, 0, 0}, {kept.face[kAfter[kAfter[slot]]], tag, kept.face[slot]}};
    kept.next[slot] = end_of(at, 0);
    height[at] = 1.0;
  }
  close(std::span(made).first(count), height);
  if (count < above.size())
    count_ = fill_places(above.subspan(count), count_,
                         [&](std::size_t from, std::size_t place) { move(from, place); });
  pad_corners();
  return true;
}

void ClippedPolyhedron::close(std::span<const std::uint16_t> made, const Numbers& height) noexcept {
  for (const std::uint16_t n : made) {
    EdgeEnd at = links_[n].next[0];
    while (!(height[corner_of(at)] > kOnPlane)) at = walked(at);
    const std::size_t other = corner_of(at);
    links_[n].next[2] = end_of(other, 1);
    links_[other].next[1] = end_of(n, 2);
  }
}

void ClippedPolyhedron::move(std::size_t from, std::size_t place) noexcept {
  for (Numbers* all : {&x_, &y_, &z_}) (*all)[place] = (*all)[from];
  const Links& moved = links_[place] = links_[from];
  for (std::size_t s = 0; s < 3; ++s)
    links_[corner_of(moved.next[s])].next[slot_of(moved.next[s])] = end_of(place, s);
}

}  // namespace feltwire
