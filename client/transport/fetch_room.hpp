#pragma once
// How much of a scene a client fetches, whatever its server offers.

#include <cstddef>
#include <cstdint>

namespace feltwire {

/// The room for the meshes of one scene. What the server announces takes its place here before
/// anything of it is asked for, so that no memory is taken on the word of a server.
class FetchRoom {
 public:
  /// Larger surfaces stay on the server: a client in a scanned city would fetch for minutes.
  static constexpr std::uint32_t kMostTriangles = 200'000;  // of all surfaces together
  /// A tool with a body meets a mesh as a grid of distances. Each is made of up to 19 x 19 x 19
  /// bricks, which are 27 MB, however few triangles the mesh has.
  static constexpr std::uint32_t kMostGrids = 16;
  /// [bytes] of the grids of one scene together; two of the largest. Meshes beyond it stay planes.
  static constexpr std::size_t kMostGridBytes = std::size_t{56} << 20;

  /// Whether a mesh of so many fits; then it takes its place.
  bool take_surface(std::uint32_t vertices, std::uint32_t triangles) noexcept {
    // No more corners than triangles have: a server cannot make this grow.
    if (triangles > triangles_ || vertices > 3 * std::uint64_t{triangles}) return false;
    triangles_ -= triangles;
    return true;
  }
  /// Whether a solid fits, whose mesh becomes a grid; then it takes its place. A primitive has no
  /// triangles.
  bool take_solid(std::uint32_t vertices, std::uint32_t triangles) noexcept {
    const std::uint32_t grids = triangles > 0 ? 1 : 0;
    if (grids > grids_ || !take_surface(vertices, triangles)) return false;
    grids_ -= grids;
    return true;
  }

 private:
  std::uint32_t triangles_ = kMostTriangles, grids_ = kMostGrids;
};

}  // namespace feltwire
