#include "core/local_model_extraction/whole_body_data.hpp"

#include "core/local_model_extraction/fitted_patches.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {

bool can_travel(const BodyTool& tool) noexcept {
  return tool.polygons() == nullptr && tool.shell().points.size() <= kMostBodyPoints;
}

bool travels(const BodyTool& tool, const Object& object) noexcept {
  return can_travel(tool) && !is_fitted(object.shape);
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

SolidData solid_data(const Object& object, std::uint16_t index) {
  return {.object = index,
          .shape = object.shape,
          .from_inside = object.felt_from == Side::inside,
          .pose = object.pose,
          .material = object.material};
}

}  // namespace feltwire
