#include "core/mesh/thin_solid.hpp"

#include <array>
#include <cstdio>

namespace feltwire {

std::optional<std::string> warning_of_thin_solid(const MeshSurface& surface) {
  constexpr double kThinnest = 4.0;  // [skins]
  const TriangleMesh& mesh = surface.mesh();
  const double thickness = 2.0 * mesh.half_extents().minCoeff();
  const double least = kThinnest * surface.skin();
  if (!mesh.report().closed() || thickness >= least) return std::nullopt;
  std::array<char, 240> text{};
  std::snprintf(text.data(), text.size(),
                "the solid is %.3g m thin and %.3g m large: a hand may pass through it; make it at "
                "least %.3g m thick, or leave one sheet of it and set double_sided",
                thickness, mesh.report().size, least);
  return text.data();
}

}  // namespace feltwire
