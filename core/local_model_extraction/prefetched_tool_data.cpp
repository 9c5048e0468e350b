#include "core/local_model_extraction/prefetched_tool_data.hpp"

#include "core/local_model_extraction/fitted_patches.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {

bool can_travel(const BodyTool& tool) noexcept {
  return tool.polygons() == nullptr && tool.shell().points.size() <= kMostBodyPoints;
}

BodyData body_data(const BodyTool& tool, const std::optional<Vec3>& gravity) {
  BodyData data{.coupling = tool.coupling(),
                .inertia = tool.inertia(),
                .contact_area = tool.contact_area(),
                .area = tool.shell().area,
                .points = tool.shell().points};
  if (gravity) data.inertia.gravity = *gravity;
  return data;
}

SolidData solid_data(const ToolView& view, std::uint16_t index) {
  const Object& object = view.objects()[index];
  return {.object = index,
          .shape = is_fitted(object.shape) ? Shape{} : object.shape,
          .mesh = {},
          .from_inside = object.felt_from == Side::inside,
          .pose = object.pose,
          .material = object.material};
}

SolidData solid_data_with_triangles(const ToolView& view, std::uint16_t index) {
  SolidData data = solid_data(view, index);
  if (const MeshSurface* surface = view.sampled_mesh(index)) {
    data.mesh = {surface->mesh().vertices(), surface->mesh().triangles()};
    for (Vec3& vertex : data.mesh.vertices) vertex += surface->mesh().origin();
  }
  return data;
}

}  // namespace feltwire
