#pragma once
// The answers to clients that draw a scene: its objects, guides and tools (PROTOCOL.md, "Shapes of
// a scene").

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "core/geometry/triangle_soup.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/scene_in_view.hpp"

namespace feltwire {

/// The next shapes of the group, at most control::kMaxShapes. A name longer than control::kMaxName
/// is shortened.
control::ShapeDescriptions described_shapes(const SceneInView::CurrentScene& current,
                                            const control::DescribeShapes& request);

/// Gives out vertices and triangles. Owns the triangles of grids: they take 30 to 70 ms, so they
/// are made once for each version of a scene. It is on the control thread.
class ShapeParts {
 public:
  /// The next part, or the refusal. `scene`: the number of the scene among those of the server.
  control::Message part(std::size_t scene, const SceneInView::CurrentScene& current,
                        const control::GetShape& request);

 private:
  struct Surface {
    std::uint32_t version = 0;
    TriangleSoup triangles;
  };
  std::map<std::pair<std::size_t, std::uint32_t>, Surface> grids_;
};

}  // namespace feltwire
