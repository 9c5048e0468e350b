#pragma once
// Triangles on the same three corners: which of them are kept.

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace feltwire::doubled_faces {

struct KeptFaces {
  std::vector<Triangle> triangles;  // a face at the place of its first triangle; empty: all stay
  std::size_t same = 0;             // triangles left out that face as another one does
  std::size_t opposed = 0;          // faces with triangles of both sides, of which one was chosen
  std::size_t both_sides = 0;       // faces that keep a triangle of each side
};

/// Keeps one triangle of those that have the same corners and face the same way. If a face has
/// triangles that look to both sides, the one stays that agrees with the neighbours of the face;
/// neighbours that have both sides themselves are decided together with it. If no neighbour
/// decides, or they are equally divided, both sides stay. The order of the triangles does not
/// matter.
///
/// `solid`: the surface is meant to bound a solid. Then faces that form a closed shell which no
/// neighbour decides are kept with their outside outwards.
KeptFaces keep_one_of_each(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                           bool solid);

}  // namespace feltwire::doubled_faces
