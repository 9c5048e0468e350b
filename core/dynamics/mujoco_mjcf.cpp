#include "core/dynamics/mujoco_mjcf.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>

#include "core/base/captured_files.hpp"
#include "core/base/foreign_content.hpp"
#include "core/base/json_document.hpp"
#include "core/base/regular_file.hpp"
#include "core/dynamics/mujoco_buffers.hpp"
#include "core/dynamics/mujoco_check.hpp"
#include "core/dynamics/refused_model.hpp"
#include "core/dynamics/unpacked_files.hpp"
#include "core/dynamics/urdf_paths.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

std::string geom_name(const mjModel& model, int geom) {
  const char* name = mj_id2name(&model, mjOBJ_GEOM, geom);
  return name != nullptr ? name : "geom" + std::to_string(geom);
}

/// Describes a geom in a message. A geom without a name is described by its number in the file.
std::string described(const mjModel& model, int geom) {
  const char* name = mj_id2name(&model, mjOBJ_GEOM, geom);
  const char* body = mj_id2name(&model, mjOBJ_BODY, model.geom_bodyid[geom]);
  return (name != nullptr ? "geom '" + std::string(name) + "'"
                          : "the geom without a name, number " + std::to_string(geom + 1)) +
         " of body '" + (body != nullptr ? body : "?") + "'";
}

/// The meshes of a file for haptic rendering. Reads each mesh once.
class MjcfMeshes {
 public:
  MjcfMeshes(const mjModel& model, const std::string& file) : model_(model), file_(file) {}

  /// Returns the mesh of a geom in MuJoCo's frame. Its origin is the centre of mass, and its axes
  /// are the principal axes of inertia.
  Mesh mesh_of(int geom) {
    const int id = model_.geom_dataid[geom];
    if (const auto at = known_.find(id); at != known_.end()) return at->second;
    TriangleSoup soup;
    const float* vertex = model_.mesh_vert + std::ptrdiff_t{3} * model_.mesh_vertadr[id];
    for (int v = 0; v < model_.mesh_vertnum[id]; ++v, vertex += 3)
      soup.vertices.emplace_back(vertex[0], vertex[1], vertex[2]);
    const int* face = model_.mesh_face + std::ptrdiff_t{3} * model_.mesh_faceadr[id];
    for (int t = 0; t < model_.mesh_facenum[id]; ++t, face += 3)
      soup.triangles.push_back({static_cast<std::uint32_t>(face[0]),
                                static_cast<std::uint32_t>(face[1]),
                                static_cast<std::uint32_t>(face[2])});
    try {
      TriangleMesh triangles(soup, {}, true);  // MuJoCo treats each mesh as a solid.
      if (triangles.report().closed() && triangles.report().volume < 0.0) triangles.turn();
      return known_[id] = Mesh{std::make_shared<MeshSurface>(std::move(triangles))};
    } catch (const std::exception& error) {
      throw RefusedModel(file_ + ": " + described(model_, geom) + ": " + error.what(),
                         file_ + ": a geom of it: " + error.what());
    }
  }

 private:
  const mjModel& model_;
  const std::string& file_;
  std::map<int, Mesh> known_;
};

Shape shape_of(const mjModel& model, int geom, const std::string& file, MjcfMeshes& meshes) {
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
    case mjGEOM_MESH:
      return meshes.mesh_of(geom);
    default:
      break;
  }
  constexpr const char* kShapes =
      ": only plane, sphere, capsule, cylinder, box and mesh can be felt; replace it by these, or "
      "make it decoration with contype=\"0\" conaffinity=\"0\"";
  throw RefusedModel(file + ": " + described(model, geom) + kShapes,
                     file + ": a geom of it" + kShapes);
}

void give_material(const mjModel& model, int geom, const MjcfMaterials& materials, Object& object) {
  const int number = model.geom_matid[geom];
  const char* own = mj_id2name(&model, mjOBJ_GEOM, geom);
  const char* of = number >= 0 ? mj_id2name(&model, mjOBJ_MATERIAL, number) : nullptr;
  for (const char* name : {own, of})
    if (name != nullptr)
      for (const MjcfMaterials::Named& named : materials.named)
        if (named.name == name) {
          object.material = named.material;
          object.material_name = named.material_name;
          return;
        }
  object.material = materials.other;
  object.material_name = materials.other_name;
}

void check_names(const mjModel& model, const MjcfMaterials& materials, const std::string& file) {
  for (const MjcfMaterials::Named& named : materials.named)
    if (mj_name2id(&model, mjOBJ_GEOM, named.name.c_str()) < 0 &&
        mj_name2id(&model, mjOBJ_MATERIAL, named.name.c_str()) < 0)
      throw RefusedModel(file + ": has no geom and no material '" + named.name +
                         "' that the scene gives a feel to; correct the name");
}

/// Returns warnings about suspicious meshes. MuJoCo replaces each mesh by its convex hull, so an
/// open mesh may go unnoticed until a hand enters it. A very large mesh is probably in millimetres.
std::vector<std::string> odd_meshes(const std::vector<Object>& objects) {
  constexpr double kLargest = 20.0;  // [m] A larger mesh is probably in millimetres.
  std::vector<std::string> warnings;
  for (const Object& object : objects) {
    const auto* mesh = std::get_if<Mesh>(&object.shape);
    if (mesh == nullptr) continue;
    const MeshReport& report = mesh->surface->mesh().report();
    if (!report.closed())
      warnings.push_back("object '" + object.name +
                         "': its mesh is not closed: " + open_text(report) +
                         "; a hand may fall in where it is open: mend the mesh's file");
    const double size = report.size;
    if (size <= kLargest) continue;
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(),
                  "': its mesh is %.3g m large; if its file is in millimetres, give the mesh "
                  "scale=\"0.001 0.001 0.001\"",
                  size);
    warnings.push_back("object '" + object.name + text.data());
  }
  return warnings;
}

/// Returns whether the text has an element of Xacro, the macro language of URDF files, outside of a
/// comment. MuJoCo would ignore the element, and the robot would lack parts.
bool has_xacro(std::string_view text) {
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at + 1)) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<xacro:")) return true;
    if (rest.starts_with("<!--")) at = std::min(text.find("-->", at), text.size() - 1);
  }
  return false;
}

/// Reads the file before MuJoCo does, because MuJoCo's message about an unreadable file says less.
std::string read_xml(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::string text;
  try {
    text = read_text(file);
  } catch (const FileError& error) {
    throw RefusedModel(error.what());
  }
  if (const auto foreign = foreign_content(text)) throw RefusedModel(name + ": " + *foreign);
  const std::string_view body = without_byte_order_mark(text);
  if (const std::size_t at = body.find_first_not_of(" \t\r\n");
      at == std::string_view::npos || body[at] != '<')
    throw RefusedModel(name +
                       ": does not begin with '<', so it is no XML; name an MJCF or URDF file");
  if (has_xacro(body))
    throw RefusedModel(name + ": is a template of Xacro; expand it with: xacro " +
                       file.filename().string() + " > robot.urdf");
  return text;
}

/// Reads a model with MuJoCo, which opens files by itself. So this function writes recorded files
/// to the disk for MuJoCo, and records the files that MuJoCo has read.
mujoco::Loaded read_model(const std::filesystem::path& file) {
  constexpr std::size_t kMost = std::size_t{1} << 30;  // [bytes] largest size of a file
  const FileReading reading = file_reading_of_this_thread;
  if (reading.given != nullptr) {
    const UnpackedFiles unpacked(*reading.given);
    const std::filesystem::path place = unpacked.place(file.string());
    const auto text = with_paths_kept(read_xml(file), place.parent_path());
    mujoco::Loaded loaded =
        mujoco::load_file(place.string(), unpacked.root().string(), text ? &*text : nullptr);
    if (loaded.model == nullptr)
      loaded.error += "; where a file that it names was not kept, name the scene's own file";
    return loaded;
  }
  const auto text = with_paths_kept(read_xml(file), file.parent_path());
  mujoco::Loaded loaded = mujoco::load_file(file.string(), {}, text ? &*text : nullptr);
  if (reading.keep != nullptr)
    for (const std::string& name : loaded.files) read_regular_file(name, kMost);
  return loaded;
}

}  // namespace

std::shared_ptr<const Mechanism> load_mjcf(const std::filesystem::path& file,
                                           const MjcfMaterials& materials, double tick,
                                           std::vector<Object>& objects,
                                           const SetStart& set_start) {
  const std::string name = file.string();
  mujoco::Loaded loaded = read_model(file);
  if (loaded.model == nullptr) throw FileError(name + ": " + loaded.error);
  mjModel& model = *loaded.model;
  check_names(model, materials, name);
  // Use Euler's method. mj_step1 and mj_step2 together make one Euler step, but Runge-Kutta would
  // need more evaluations.
  if (model.opt.integrator == mjINT_RK4) model.opt.integrator = mjINT_EULER;
  model.opt.timestep = tick;

  std::vector<double> start;
  if (set_start) {
    start.assign(model.qpos0, model.qpos0 + model.nq);
    set_start(model, start.data());
  }

  const mujoco::Data data = mujoco::make_data(model, start);
  if (data == nullptr) throw RefusedModel(name + ": MuJoCo cannot evaluate it where it starts");
  std::vector<int> object_of(static_cast<std::size_t>(model.ngeom), -1);
  std::vector<Mechanism::Part> parts;
  MjcfMeshes meshes(model, name);
  for (const bool moving : {false, true})
    for (int g = 0; g < model.ngeom; ++g) {
      const int body = model.geom_bodyid[g];
      if ((model.body_weldid[body] != 0) != moving) continue;
      if (model.geom_contype[g] == 0 && model.geom_conaffinity[g] == 0) continue;
      Object object;
      object.name = geom_name(model, g);
      object.shape = shape_of(model, g, name, meshes);
      give_material(model, g, materials, object);
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
    throw RefusedModel(name +
                       ": no geom of it collides, so there is nothing to touch; give one a contype "
                       "or conaffinity other than 0");
  const std::size_t still = objects.size() - parts.size();
  mujoco::leave_room_open(model);
  const std::vector<std::string> odd = odd_meshes(objects);
  std::vector<std::string> warnings =
      mujoco::warnings_of(model, start, objects, object_of, still, parts);
  warnings.insert(warnings.end(), odd.begin(), odd.end());
  return std::make_shared<Mechanism>(
      std::shared_ptr<const mjModel>(loaded.model.release(), mujoco::DeleteModel{}), still,
      std::move(parts), std::move(warnings), std::move(start));
}

}  // namespace feltwire
