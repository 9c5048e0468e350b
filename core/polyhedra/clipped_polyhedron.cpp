#include "core/polyhedra/clipped_polyhedron.hpp"

#include <algorithm>

namespace feltwire {
namespace {

/// [m] A corner this little above a plane lies on it: rounding of coordinates of some metres.
constexpr double kOn = 1e-14;

}  // namespace

ClippedPolyhedron& ClippedPolyhedron::operator=(const ClippedPolyhedron& other) noexcept {
  if (this == &other) return *this;
  count_ = other.count_;
  std::copy_n(other.x_.begin(), count_, x_.begin());
  std::copy_n(other.y_.begin(), count_, y_.begin());
  std::copy_n(other.z_.begin(), count_, z_.begin());
  std::copy_n(other.links_.begin(), count_, links_.begin());
  return *this;
}

void ClippedPolyhedron::assign(const Polyhedron& solid, const Mat3& rotation,
                               const Vec3& position) noexcept {
  count_ = 0;
  if (solid.graph.size() > kCorners) [[unlikely]]
    return;  // never: polyhedron() limits the vertices, and so the corners
  for (const GraphCorner& corner : solid.graph) {
    const Vec3 at = rotation * solid.vertices[corner.vertex] + position;
    x_[count_] = at.x();
    y_[count_] = at.y();
    z_[count_] = at.z();
    links_[count_++] = {corner.next, {kOwn, kOwn, kOwn}, corner.back};
  }
}

bool ClippedPolyhedron::cut(const Vec3& normal, double offset, Tag tag) noexcept {
  if (count_ == 0) return false;
  alignas(16) Heights height;
  Eigen::Map<Eigen::ArrayXd, Eigen::Aligned16> heights(height.data(),
                                                       static_cast<Eigen::Index>(count_));
  heights = normal.x() * x() + normal.y() * y() + normal.z() * z() - offset;
  if (!(heights.maxCoeff() > kOn)) return true;
  if (heights.minCoeff() >= -kOn) {
    count_ = 0;
    return false;
  }
  const std::size_t old_count = count_;
  if (!has_room(height)) [[unlikely]]
    return true;
  std::array<std::uint16_t, kCorners> above;
  std::size_t above_count = 0;
  for (std::size_t v = 0; v < old_count; ++v) {
    if (!(height[v] > kOn)) continue;
    above[above_count++] = static_cast<std::uint16_t>(v);
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint16_t in = links_[v].next[s];
      if (height[in] > kOn) continue;
      // A corner on the edge from `in`; the new face lies between its other two edges.
      const double part = std::clamp(height[in] / (height[in] - height[v]), 0.0, 1.0);
      x_[count_] = x_[in] + part * (x_[v] - x_[in]);
      y_[count_] = y_[in] + part * (y_[v] - y_[in]);
      z_[count_] = z_[in] + part * (z_[v] - z_[in]);
      const std::uint8_t slot = links_[v].back[s];
      Links& kept = links_[in];
      links_[count_] = {
          {in, 0, 0}, {kept.face[kAfter[kAfter[slot]]], tag, kept.face[slot]}, {slot, 0, 0}};
      kept.next[slot] = static_cast<std::uint16_t>(count_++);
      kept.back[slot] = 0;
    }
  }
  close(old_count);
  remove(std::span(above).first(above_count));
  return true;
}

bool ClippedPolyhedron::has_room(const Heights& height) const noexcept {
  if (count_ + 3 * count_ / 2 <= kCorners) return true;  // a new corner on every edge
  std::size_t crossing = 0;
  for (std::size_t v = 0; v < count_; ++v)
    for (std::size_t s = 0; s < 3; ++s)
      crossing += height[v] > kOn && !(height[links_[v].next[s]] > kOn) ? 1 : 0;
  return count_ + crossing <= kCorners;
}

void ClippedPolyhedron::close(std::size_t first_new) noexcept {
  for (std::size_t n = first_new; n < count_; ++n) {
    std::uint16_t at = links_[n].next[0];
    std::uint8_t entered = links_[n].back[0];
    while (at < first_new) {
      const Links& links = links_[at];
      const std::size_t out = kAfter[entered];
      at = links.next[out];
      entered = links.back[out];
    }
    links_[n].next[2] = at;
    links_[n].back[2] = 1;
    links_[at].next[1] = static_cast<std::uint16_t>(n);
    links_[at].back[1] = 2;
  }
}

void ClippedPolyhedron::remove(std::span<const std::uint16_t> gone) noexcept {
  std::size_t left = gone.size();  // to remove; those behind are beyond the end
  for (std::size_t k = 0; k < left; ++k) {
    while (left > k && gone[left - 1] == count_ - 1) {
      --left;
      --count_;
    }
    if (k == left) return;
    const std::uint16_t place = gone[k];
    --count_;
    x_[place] = x_[count_];
    y_[place] = y_[count_];
    z_[place] = z_[count_];
    const Links& moved = links_[place] = links_[count_];
    for (std::size_t s = 0; s < 3; ++s) links_[moved.next[s]].next[moved.back[s]] = place;
  }
}

}  // namespace feltwire
