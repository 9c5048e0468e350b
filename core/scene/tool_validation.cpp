// The rules for the tools of a scene.

#include "core/contact/ball.hpp"
#include "core/scene/validation.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {

MaybeViolation check(const HandTool& tool, std::span<const Object> objects) {
  if (tool.body && tool.body->polygons() != nullptr &&
      tool.body->polygons()->solids.size() != objects.size())
    return Violation{"body.contact", "is polygons, with " +
                                         std::to_string(tool.body->polygons()->solids.size()) +
                                         " solids for " + std::to_string(objects.size()) +
                                         " objects; make it for this scene"};
  if (tool.radius == 0.0) return std::nullopt;
  if (tool.body) return Violation{"sphere", "is a second tool beside body; keep one of the two"};
  if (auto violation = positive("sphere.radius", tool.radius, kMaxLength, " [m]")) return violation;
  for (const Object& object : objects)
    if (!ball_fits(object.shape, object.felt_from, tool.radius))
      return Violation{"sphere.radius",
                       "is " + number_text(tool.radius) + " m, too large for object '" +
                           object.name +
                           "': a hollow has no room for it, or a grid's band is smaller; make the "
                           "tool smaller or these larger"};
  return std::nullopt;
}

MaybeViolation broken_tools(std::size_t count) {
  if (count >= 1 && count <= kMaxTools) return std::nullopt;
  return Violation{"tools", "must be 1 to " + std::to_string(kMaxTools) + ", are " +
                                std::to_string(count) + "; " +
                                (count == 0 ? "name one, or leave them out" : "name fewer")};
}

std::string description_of(const HandTool& tool) {
  return tool.name.empty() ? "tool" : "tool '" + tool.name + "'";
}

}  // namespace feltwire
