#include "core/polyhedra/depth_integrals.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/polyhedra/depth_planes.hpp"
#include "core/polyhedra/penetration_cell.hpp"

namespace feltwire {
namespace {

using Tag = ClosestFaceCells::Tag;

/// Adds the contact with a hollow solid. A point outside the hollow is as deep as its largest
/// distance beyond a face.
void add_hollow(const PlacedPart& tool, const ClippedPolyhedron& whole, const DepthPlanes& planes,
                bool slides, DepthSums& sums) {
  ClosestFaceCells cells(whole, Vec3::Zero(), 0.0, planes.size());
  const auto free = static_cast<Tag>(ClosestFaceCells::kCell + planes.size());
  std::array<PenetrationCell, kMostDepthPlanes> of;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    cells.insert(planes[i].normal, planes[i].offset, i);
    of[i] = PenetrationCell(planes[i].normal, -planes[i].offset, tool.origin, free);
  }
  add_cells(cells, std::span(of).first(planes.size()), planes, slides, sums);
}

}  // namespace

void add_depth(const PlacedPart& tool, const SolidPart& solid, bool hollow, const Vec3* away,
               bool slides, DepthSums& sums) noexcept {
  const DepthPlanes planes(solid, away);
  ClippedPolyhedron inside;
  inside.assign(tool.shape, tool.rotation, tool.origin);
  if (hollow) {
    add_hollow(tool, inside, planes, slides, sums);
    return;
  }
  const auto cut = [&](std::size_t i) {
    return inside.cut(planes[i].normal, planes[i].offset, static_cast<Tag>(i));
  };
  if (!cut(planes.facing())) return;
  // [m] least depth below each face, or a lower bound of it.
  std::array<double, kMostDepthPlanes> least;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const ClippedPolyhedron::Extent above = inside.extent(planes[i].normal, planes[i].offset);
    least[i] = -above.most;
    if (above.most > 0.0 && !cut(i)) return;
  }
  // A face can be the nearest face of a point only if its least depth is below the largest depth of
  // every other face. In most cases, the face towards the tool gives this bound.
  double bound = std::numeric_limits<double>::infinity();
  const DepthPlane& facing = planes[planes.facing()];
  if (!facing.inner) bound = -inside.extent(facing.normal, facing.offset).least;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (planes[i].inner || !(least[i] < bound)) continue;
    const ClippedPolyhedron::Extent above = inside.extent(planes[i].normal, planes[i].offset);
    least[i] = -above.most;
    bound = std::min(bound, -above.least);
  }
  // Begin with the faces that are nearest to the middle of the contact, because they have the
  // largest cells. Little then remains to cut for the other faces.
  std::array<std::pair<double, std::size_t>, kMostDepthPlanes> by_depth;
  std::size_t count = 0;
  const Vec3 middle = inside.middle();
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (!planes[i].inner && least[i] < bound)
      by_depth[count++] = {planes[i].offset - planes[i].normal.dot(middle), i};
  if (count == 0) return;
  const auto faces = std::span(by_depth).first(count);
  std::ranges::sort(faces);
  const DepthPlane& nearest = planes[faces[0].second];
  ClosestFaceCells cells(inside, nearest.normal, nearest.offset, 0);
  std::array<PenetrationCell, kMostDepthPlanes> of;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t face = faces[k].second;
    if (k > 0) cells.insert(planes[face].normal, planes[face].offset, k);
    of[k] = PenetrationCell(-planes[face].normal, planes[face].offset, tool.origin,
                            static_cast<Tag>(face));
  }
  add_cells(cells, std::span(of).first(count), planes, slides, sums);
}

}  // namespace feltwire
