#include "server/scene/apply_live_change.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <stdexcept>

#include "protocol/session/material_fields.hpp"

namespace feltwire {

std::size_t object_index(const Scene& scene, const std::string& name) {
  const std::vector<Object>& objects = scene.objects();
  const auto found = std::ranges::find(objects, name, &Object::name);
  if (found != objects.end()) return static_cast<std::size_t>(found - objects.begin());
  constexpr std::size_t kMostNames = 20;
  std::string names;
  for (std::size_t i = 0; i < std::min(objects.size(), kMostNames); ++i)
    names += (names.empty() ? "" : ", ") + objects[i].name;
  if (objects.size() > kMostNames) names += ", ...";
  throw std::invalid_argument("object: there is no object '" + name + "' in scene '" +
                              scene.name() + "'; name one of: " + names);
}

Changed changed(const Scene& scene, const MaterialChange& change) {
  const std::size_t index = object_index(scene, change.object);
  Material material = scene.objects()[index].material;
  std::string what;
  for (const MaterialField& field : kMaterialFields) {
    const std::optional<double>& wanted = change.*field.wanted;
    if (!wanted) continue;
    what += fmt::format("{}{} {} -> {}", what.empty() ? "" : ", ", field.name,
                        material.*field.value, *wanted);
    if (!field.unit.empty()) what += fmt::format(" [{}]", field.unit);
    material.*field.value = *wanted;
  }
  if (what.empty())
    throw std::invalid_argument("object '" + change.object +
                                "': no field of its material is given; give stiffness, damping, "
                                "static_friction, dynamic_friction or viscous_friction");
  Scene next = scene;
  next.set_material(index, material);
  return {"object '" + change.object + "': " + what,
          std::make_shared<const Scene>(std::move(next))};
}

}  // namespace feltwire
