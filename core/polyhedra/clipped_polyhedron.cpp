#include "core/polyhedra/clipped_polyhedron.hpp"

#include <algorithm>

namespace feltwire {
namespace {

/// [m] A corner this little above a plane lies on it: rounding of coordinates of some metres.
constexpr double kOn = 1e-14;
constexpr std::size_t kCrossings = 512;  // of one cut with edges

/// The corners that a cut makes: one for both directions of an edge.
struct Crossings {
  struct Known {
    std::uint16_t low, high, made;
  };
  std::array<Known, kCrossings> known;
  std::size_t count = 0;

  const Known* find(std::uint16_t low, std::uint16_t high) const noexcept {
    for (std::size_t i = 0; i < count; ++i)
      if (known[i].low == low && known[i].high == high) return &known[i];
    return nullptr;
  }
};

}  // namespace

ClippedPolyhedron& ClippedPolyhedron::operator=(const ClippedPolyhedron& other) noexcept {
  if (this == &other) return *this;
  vertex_count_ = other.vertex_count_;
  edge_count_ = other.edge_count_;
  face_count_ = other.face_count_;
  std::copy_n(other.vertices_.begin(), vertex_count_, vertices_.begin());
  std::copy_n(other.edges_.begin(), edge_count_, edges_.begin());
  std::copy_n(other.faces_.begin(), face_count_, faces_.begin());
  return *this;
}

void ClippedPolyhedron::assign(const Polyhedron& solid, const Mat3& rotation,
                               const Vec3& position) noexcept {
  vertex_count_ = edge_count_ = face_count_ = 0;
  if (solid.vertices.size() > kVertices || solid.loop.size() > kEdges ||
      solid.planes.size() > kFaces) [[unlikely]]
    return;  // never: polyhedron() limits the vertices, and so the rest
  for (const Vec3& v : solid.vertices) vertices_[vertex_count_++] = rotation * v + position;
  for (std::size_t f = 0; f < solid.planes.size(); ++f) {
    const auto loop = solid.face(f);
    const auto begin = static_cast<std::uint16_t>(edge_count_);
    for (std::size_t k = 0; k < loop.size(); ++k)
      edges_[edge_count_++] = {static_cast<std::uint16_t>(loop[k]),
                               static_cast<std::uint16_t>(loop[(k + 1) % loop.size()])};
    faces_[face_count_++] = {begin, static_cast<std::uint16_t>(edge_count_), kOwn};
  }
}

bool ClippedPolyhedron::cut(const Vec3& normal, double offset, std::uint32_t tag) noexcept {
  std::array<double, kVertices> height;
  std::size_t above = 0;
  double lowest = 0.0;
  for (std::size_t v = 0; v < vertex_count_; ++v) {
    height[v] = normal.dot(vertices_[v]) - offset;
    above += height[v] > kOn ? 1 : 0;
    lowest = std::min(lowest, height[v]);
  }
  if (above == 0) return vertex_count_ > 0;
  if (lowest >= -kOn) {
    vertex_count_ = edge_count_ = face_count_ = 0;
    return false;
  }

  constexpr std::uint16_t kNone = 0xFFFF;
  std::array<Vec3, kVertices> vertices;
  std::array<std::uint16_t, kVertices> number;
  std::fill_n(number.begin(), vertex_count_, kNone);
  std::array<Edge, kEdges> edges;
  std::array<Face, kFaces> faces;
  std::array<Edge, kCrossings> cap;
  Crossings crossings;
  std::size_t vertex_count = 0, edge_count = 0, face_count = 0, cap_count = 0;
  const auto kept = [&](std::uint16_t v) {
    if (number[v] == kNone) {
      number[v] = static_cast<std::uint16_t>(vertex_count);
      vertices[vertex_count++] = vertices_[v];
    }
    return number[v];
  };
  const auto crossed = [&](std::uint16_t a, std::uint16_t b) {
    const auto [low, high] = std::minmax(a, b);
    if (const auto* known = crossings.find(low, high)) return known->made;
    const double part = std::clamp(height[low] / (height[low] - height[high]), 0.0, 1.0);
    const auto made = static_cast<std::uint16_t>(vertex_count);
    vertices[vertex_count++] = vertices_[low] + part * (vertices_[high] - vertices_[low]);
    crossings.known[crossings.count++] = {low, high, made};
    return made;
  };
  for (std::size_t f = 0; f < face_count_; ++f) {
    const Face face = faces_[f];
    const std::size_t begin = edge_count;
    // A convex face is left and entered once. Where rounding makes it more, any pairing closes it,
    // as all the places lie on one line.
    std::array<std::uint16_t, 8> left, entered;
    std::size_t lefts = 0, entries = 0;
    for (std::size_t e = face.begin; e < face.end; ++e) {
      const auto [from, to] = edges_[e];
      const bool in = !(height[from] > kOn), stays = !(height[to] > kOn);
      if (!in && !stays) continue;
      if (vertex_count + 2 >= kVertices || edge_count + left.size() + 2 >= kEdges ||
          crossings.count + 1 >= kCrossings || cap_count + left.size() >= kCrossings ||
          lefts == left.size() || entries == entered.size()) [[unlikely]]
        return true;  // no room: as it was
      if (in && stays) {
        edges[edge_count++] = {kept(from), kept(to)};
      } else if (in) {
        const std::uint16_t at = crossed(from, to);
        edges[edge_count++] = {kept(from), at};
        left[lefts++] = at;
      } else {
        const std::uint16_t at = crossed(from, to);
        edges[edge_count++] = {at, kept(to)};
        entered[entries++] = at;
      }
    }
    for (std::size_t k = 0; k < std::min(lefts, entries); ++k) {
      edges[edge_count++] = {left[k], entered[k]};
      cap[cap_count++] = {entered[k], left[k]};
    }
    if (edge_count > begin)
      faces[face_count++] = {static_cast<std::uint16_t>(begin),
                             static_cast<std::uint16_t>(edge_count), face.tag};
  }
  if (cap_count > 0) {
    if (face_count == kFaces || edge_count + cap_count > kEdges) [[unlikely]]
      return true;
    const auto begin = static_cast<std::uint16_t>(edge_count);
    std::copy_n(cap.begin(), cap_count, edges.begin() + static_cast<std::ptrdiff_t>(edge_count));
    edge_count += cap_count;
    faces[face_count++] = {begin, static_cast<std::uint16_t>(edge_count), tag};
  }
  vertex_count_ = vertex_count;
  edge_count_ = edge_count;
  face_count_ = face_count;
  std::copy_n(vertices.begin(), vertex_count, vertices_.begin());
  std::copy_n(edges.begin(), edge_count, edges_.begin());
  std::copy_n(faces.begin(), face_count, faces_.begin());
  return true;
}

}  // namespace feltwire
