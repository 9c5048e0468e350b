#pragma once
// A convex polyhedron that is cut by planes, without memory from the heap.

#include <array>
#include <cstdint>
#include <span>

#include "core/polyhedra/polyhedron.hpp"

namespace feltwire {

/// The part of a polyhedron below planes. Each face is a set of directed edges that closes; their
/// order does not matter. A cut shortens edges, and closes each face and the new one by the same
/// edges in opposite directions. So the surface stays closed whatever rounding does to a corner on
/// a plane, and integrals over it by the divergence theorem are right to rounding.
class ClippedPolyhedron {
 public:
  static constexpr std::size_t kVertices = 1024, kEdges = 6144, kFaces = 1536;
  static constexpr std::uint32_t kOwn = 0xFFFFFFFF;  // the tag of a face of the polyhedron itself

  struct Edge {
    std::uint16_t from, to;  // vertices
  };
  struct Face {
    std::uint16_t begin, end;  // edges
    std::uint32_t tag;         // of the cut that made it
  };

  ClippedPolyhedron() = default;
  // Only what is in use is copied.
  ClippedPolyhedron(const ClippedPolyhedron& other) noexcept { *this = other; }
  ClippedPolyhedron& operator=(const ClippedPolyhedron& other) noexcept;

  /// The whole solid, placed at rotation * p + position.
  void assign(const Polyhedron& solid, const Mat3& rotation, const Vec3& position) noexcept;

  /// Keeps the points x with normal . x <= offset; the normal has any length but zero. The face
  /// that the cut makes gets the tag. Returns false if nothing with a volume is left. Without room
  /// for more edges the cut is left out.
  bool cut(const Vec3& normal, double offset, std::uint32_t tag) noexcept;

  bool empty() const { return vertex_count_ == 0; }
  std::span<const Vec3> vertices() const { return {vertices_.data(), vertex_count_}; }
  std::span<const Face> faces() const { return {faces_.data(), face_count_}; }
  std::span<const Edge> edges(const Face& face) const {
    return std::span(edges_).subspan(face.begin, face.end - face.begin);
  }

 private:
  std::array<Vec3, kVertices> vertices_;
  std::array<Edge, kEdges> edges_;
  std::array<Face, kFaces> faces_;
  std::size_t vertex_count_ = 0, edge_count_ = 0, face_count_ = 0;
};

}  // namespace feltwire
