#include <algorithm>

#include "core/scene/json_document.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene/mujoco_check.hpp"
#include "core/scene/mujoco_guard.hpp"

namespace feltwire {
namespace {

std::string geom_name(const mjModel& model, int geom) {
  const char* name = mj_id2name(&model, mjOBJ_GEOM, geom);
  return name != nullptr ? name : "geom" + std::to_string(geom);
}

/// Where a geom stands among the file's, for whoever has to find one that has no name.
std::string described(const mjModel& model, int geom) {
  const char* name = mj_id2name(&model, mjOBJ_GEOM, geom);
  const char* body = mj_id2name(&model, mjOBJ_BODY, model.geom_bodyid[geom]);
  return (name != nullptr ? "geom '" + std::string(name) + "'"
                          : "the geom without a name, number " + std::to_string(geom + 1)) +
         " of body '" + (body != nullptr ? body : "?") + "'";
}

Shape shape_of(const mjModel& model, int geom, const std::string& file) {
  const mjtNum* size = mujoco::entry<3>(model.geom_size, geom);
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      return Plane{};
    case mjGEOM_SPHERE:
      return Sphere{size[0]};
    case mjGEOM_CAPSULE:
      return Capsule{size[0], size[1]};
    case mjGEOM_CYLINDER:
      return Cylinder{size[0], size[1]};
    case mjGEOM_BOX:
      return Box{mujoco::vector(size)};
    default:
      throw FileError(file + ": " + described(model, geom) +
                      ": only plane, sphere, capsule, cylinder and box can be felt; replace it by "
                      "these, or make it decoration with contype=\"0\" conaffinity=\"0\"");
  }
}

Material material_of(const mjModel& model, int geom, const MjcfMaterials& materials) {
  const int number = model.geom_matid[geom];
  const char* own = mj_id2name(&model, mjOBJ_GEOM, geom);
  const char* of = number >= 0 ? mj_id2name(&model, mjOBJ_MATERIAL, number) : nullptr;
  for (const char* name : {own, of})
    if (name != nullptr)
      for (const MjcfMaterials::Named& named : materials.named)
        if (named.name == name) return named.material;
  return materials.other;
}

void check_names(const mjModel& model, const MjcfMaterials& materials, const std::string& file) {
  for (const MjcfMaterials::Named& named : materials.named)
    if (mj_name2id(&model, mjOBJ_GEOM, named.name.c_str()) < 0 &&
        mj_name2id(&model, mjOBJ_MATERIAL, named.name.c_str()) < 0)
      throw FileError(file + ": has no geom and no material '" + named.name +
                      "' that the scene gives a feel to; correct the name");
}

}  // namespace

std::shared_ptr<const Mechanism> load_mjcf(const std::filesystem::path& file,
                                           const MjcfMaterials& materials, double tick,
                                           std::vector<Object>& objects) {
  const std::string name = file.string();
  read_text(file);  // MuJoCo's own words for a file that cannot be read say less
  mujoco::Loaded loaded = mujoco::load_file(name);
  if (loaded.model == nullptr) throw FileError(name + ": " + loaded.error);
  mjModel& model = *loaded.model;
  check_names(model, materials, name);
  // mj_step1 and mj_step2 take a step between them; Runge and Kutta would need more.
  if (model.opt.integrator == mjINT_RK4) model.opt.integrator = mjINT_EULER;
  model.opt.timestep = tick;

  const mujoco::Data data = mujoco::make_data(model);
  if (data == nullptr) throw FileError(name + ": MuJoCo cannot evaluate it where it starts");
  std::vector<int> object_of(static_cast<std::size_t>(model.ngeom), -1);
  std::vector<Mechanism::Part> parts;
  for (const bool moving : {false, true})
    for (int g = 0; g < model.ngeom; ++g) {
      const int body = model.geom_bodyid[g];
      if ((model.body_weldid[body] != 0) != moving) continue;
      if (model.geom_contype[g] == 0 && model.geom_conaffinity[g] == 0) continue;
      Object object;
      object.name = geom_name(model, g);
      object.shape = shape_of(model, g, name);
      object.material = material_of(model, g, materials);
      const Pose in_body{mujoco::vector(mujoco::entry<3>(model.geom_pos, g)),
                         mujoco::quaternion(mujoco::entry<4>(model.geom_quat, g))};
      const Quaternion turned = mujoco::quaternion(mujoco::entry<4>(data->xquat, body));
      object.pose = {mujoco::vector(mujoco::entry<3>(data->xpos, body)) + turned * in_body.position,
                     turned * in_body.orientation};
      object_of[static_cast<std::size_t>(g)] = static_cast<int>(objects.size());
      objects.push_back(std::move(object));
      if (moving) parts.push_back({body, in_body});
    }
  if (objects.empty())
    throw FileError(name +
                    ": no geom of it collides, so there is nothing to touch; give one a "
                    "contype or conaffinity other than 0");
  const std::size_t still = objects.size() - parts.size();
  std::vector<std::string> warnings = mujoco::warnings_of(model, objects, object_of, still, parts);
  return std::make_shared<Mechanism>(
      std::shared_ptr<const mjModel>(loaded.model.release(), mujoco::DeleteModel{}), still,
      std::move(parts), std::move(warnings));
}

}  // namespace feltwire
