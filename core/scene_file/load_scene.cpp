#include "core/scene_file/load_scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/cancellation.hpp"
#include "core/scene_file/load_guides.hpp"
#include "core/scene_file/load_mesh.hpp"
#include "core/scene_file/read_bodies.hpp"
#include "core/scene_file/read_fields.hpp"
#include "core/scene_file/read_values.hpp"
#include "core/scene_file/read_workspace.hpp"
#include "core/scene_file/scene_text.hpp"
#include "core/scene_file/shown_error.hpp"

namespace feltwire {
namespace {

struct NamedMaterial {
  std::string name;
  Material material;
};
struct Materials {
  Names names;
  std::vector<NamedMaterial> all;
};

Materials read_materials(const JsonDocument& document, const scene_file::Scene& scene) {
  Materials materials{Names(document, "materials"), {}};
  for (const scene_file::Material* m : *scene.materials()) {
    materials.names.add(m->name()->str());
    const Material material{.stiffness = m->stiffness(),
                            .damping = m->damping(),
                            .static_friction = m->static_friction(),
                            .dynamic_friction = m->dynamic_friction(),
                            .viscous_friction = m->viscous_friction()};
    require(document, element("materials", materials.all.size()), check(material));
    materials.all.push_back({m->name()->str(), material});
  }
  return materials;
}

const Material& find_material(const JsonDocument& document, const std::string& path,
                              const Materials& materials, const std::string& name) {
  if (const auto violation = broken_name(name))
    document.fail(path + ".material", violation->message);
  if (const auto at = materials.names.find(name)) return materials.all[*at].material;
  std::string known;
  for (const NamedMaterial& m : materials.all) known += (known.empty() ? "" : ", ") + m.name;
  document.fail(path + ".material",
                "there is no material '" + name + "'; " +
                    (known.empty() ? "add it to materials" : "those of this scene are: " + known));
}

/// Returns true if a tool of the scene has a body. A tool with a body treats every mesh as a solid.
bool has_body_tool(const scene_file::Scene& scene) {
  if (scene.tool() != nullptr && scene.tool()->body() != nullptr) return true;
  if (scene.tools() == nullptr) return false;
  return std::any_of(scene.tools()->begin(), scene.tools()->end(),
                     [](const scene_file::NamedTool* tool) { return tool->body() != nullptr; });
}

Shape read_shape(const JsonDocument& document, const std::string& path,
                 const scene_file::Object& object, const std::filesystem::path& folder,
                 MeshLoader& meshes) {
  const std::string choices = names_of_primitives(false) + ", mesh, grid";
  Shape shape;
  std::string kind;
  const auto take = [&](const char* name, const Shape& given) {
    if (!kind.empty())
      document.fail(path + "." + name,
                    "is a second shape beside " + kind + "; keep exactly one of " + choices);
    kind = name;
    shape = given;
  };
  take_primitives(document, path, take);
  if (object.mesh())
    take("mesh", meshes.load(path + ".mesh", *object.mesh(), object.body() != nullptr));
  if (const auto* g = object.grid())
    take("grid", read_grid(document, path + ".grid", *g, folder, meshes.warnings()));
  if (kind.empty()) document.fail(path, "has no shape; give exactly one of " + choices);
  require(document, path + "." + kind, check(shape));
  return shape;
}

Pose read_pose(const JsonDocument& document, const std::string& path,
               const scene_file::Object& object) {
  Pose pose = pose_of(object);
  require(document, path, check(pose));
  return pose;
}

Start read_start(const JsonDocument& document, const scene_file::Scene& scene) {
  Start start;
  if (const auto* s = scene.start()) {
    if (const auto* p = s->position()) start.position = vector(*p);
    if (const auto* n = s->normal()) start.normal = vector(*n);
    require(document, "start", check(start));
  }
  return start;
}

ArmControl read_arm(const scene_file::Arm& from) {
  ArmControl arm{.stiffness = from.stiffness(),
                 .turning_stiffness = from.turning_stiffness(),
                 .damping_ratio = from.damping_ratio(),
                 .posture_stiffness = from.posture_stiffness(),
                 .largest_pull = from.largest_pull(),
                 .largest_turn = from.largest_turn(),
                 .stop_force = from.stop_force(),
                 .stop_torque = from.stop_torque(),
                 .noise = from.noise(),
                 .torque_noise = from.torque_noise(),
                 .seed = from.seed()};
  if (from.prefix() != nullptr) arm.prefix = from.prefix()->str();
  if (!std::isnan(from.gripper())) arm.gripper = from.gripper();
  return arm;
}

RemoteSeat read_seat(const JsonDocument& document, const std::string& path,
                     const scene_file::Remote& from) {
  RemoteSeat seat{.scale = from.scale(),
                  .force_scale = from.force_scale(),
                  .speed = from.speed(),
                  .force = from.force()};
  if (const auto* w = from.workspace()) read_workspace(document, path + ".workspace", *w, seat);
  if (const auto* a = from.aligned()) {
    Alignment& aligned = seat.aligned.emplace();
    aligned.gate = a->gate();
    if (const auto* q = a->orientation()) aligned.offset = quaternion(*q);
  }
  if (const auto* a = from.arm()) seat.arm = read_arm(*a);
  require(document, path, check(seat));
  if (seat.aligned) make_unit(seat.aligned->offset);
  return seat;
}

std::vector<RemoteSeat> read_seats(const JsonDocument& document, const scene_file::Scene& scene) {
  std::vector<RemoteSeat> seats;
  if (const auto* only = scene.remote()) {
    if (only->name() != nullptr)
      document.fail("remote.name", "the only seat has no name; leave it out, or use remotes");
    seats.push_back(read_seat(document, "remote", *only));
  }
  if (const auto* named = scene.remotes()) {
    if (!seats.empty())
      document.fail("remotes", "stands beside remote; put all seats into remotes");
    if (named->size() == 0 || named->size() > kMostSeats)
      document.fail("remotes", "has " + std::to_string(named->size()) + " seats; give 1 to " +
                                   std::to_string(kMostSeats));
    Names names(document, "remotes");
    for (const scene_file::Remote* from : *named) {
      const std::string path = element("remotes", seats.size());
      if (from->name() == nullptr)
        document.fail(path + ".name", "is missing; a robot is sent to its seat by this name");
      names.add(from->name()->str());
      seats.push_back(read_seat(document, path, *from));
      seats.back().name = from->name()->str();
    }
  }
  for (std::size_t i = 0; i < seats.size(); ++i) {
    if (!seats[i].arm) continue;
    const std::string path =
        (scene.remotes() != nullptr ? element("remotes", i) : std::string("remote")) + ".arm";
    if (scene.mjcf() == nullptr)
      document.fail(path,
                    "is an arm of the scene's MJCF file, and the scene has none; give it an "
                    "mjcf, or leave out the arm: then a robot may join");
    for (std::size_t other = 0; other < i; ++other)
      if (seats[other].arm && seats[other].arm->prefix == seats[i].arm->prefix)
        document.fail(path + ".prefix", "is '" + seats[i].arm->prefix + "' as for the seat '" +
                                            seats[other].name + "'; an arm has one seat");
  }
  return seats;
}

Side side(scene_file::Side given) {
  return given == scene_file::Side::inside ? Side::inside : Side::outside;
}

Scene mjcf_scene(const JsonDocument& document, const scene_file::Scene& scene,
                 const Materials& materials, const std::string& file) {
  std::vector<Object> objects;
  std::vector<RemoteSeat> seats = read_seats(document, scene);
  const auto mechanism = read_mjcf(
      document, scene, std::filesystem::path(file).parent_path(), seats,
      [&](const std::string& path, const std::string& name) -> const Material& {
        return find_material(document, path, materials, name);
      },
      objects);
  try {
    Scene result(scene.name()->str(), std::move(objects), read_start(document, scene),
                 read_guides(document, scene));
    result.set_mechanism(mechanism);
    read_tools(document, scene, std::filesystem::path(file).parent_path(), result);
    result.set_seats(std::move(seats));
    return result;
  } catch (const std::invalid_argument& error) {
    document.fail("mjcf.file", error.what());
  }
}

}  // namespace

Scene parse_scene(std::string_view json, const std::string& file) {
  const JsonDocument document(json, file, embedded::scene);
  const scene_file::Scene& scene = *scene_file::GetScene(document.buffer());
  require(document, "", broken_name(scene.name()->str()));
  const Materials materials = read_materials(document, scene);

  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  MeshLoader meshes(document, folder);
  if (has_body_tool(scene)) meshes.take_all_for_solids();
  std::vector<Object> objects;
  Names names(document, "objects");
  const auto described = [&](Scene read) {
    if (scene.description() != nullptr) read.describe(scene.description()->str());
    return read;
  };
  if (scene.mjcf()) return described(mjcf_scene(document, scene, materials, file));
  if (!scene.objects()) document.fail("objects", "is missing; add it");
  for (const scene_file::Object* o : *scene.objects()) {
    const std::string path = element("objects", objects.size());
    check_cancelled();
    begin_stage(path);
    names.add(o->name()->str());
    Object object;
    object.name = o->name()->str();
    object.shape = read_shape(document, path, *o, folder, meshes);
    object.felt_from = side(o->felt_from());
    object.pose = read_pose(document, path, *o);
    object.material = find_material(document, path, materials, o->material()->str());
    object.material_name = o->material()->str();
    objects.push_back(std::move(object));
  }
  std::vector<Guide> guides = read_guides(document, scene);
  ReadMechanism moving = read_bodies(document, scene, folder, objects);
  if (objects.empty() && guides.empty())
    document.fail("objects", "there is none to touch, and no guide; add at least one");
  Scene read(scene.name()->str(), std::move(objects), read_start(document, scene),
             std::move(guides));
  std::vector<std::string> warnings = meshes.warnings();
  warnings.insert(warnings.end(), moving.warnings.begin(), moving.warnings.end());
  read.warn(std::move(warnings));
  read.note(std::move(moving.notes));
  read.set_mechanism(std::move(moving.mechanism));
  read_tools(document, scene, folder, read);
  read.set_seats(read_seats(document, scene));
  return described(std::move(read));
}

Scene load_scene(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  try {
    return parse_scene(text, file.string());
  } catch (const FileError& error) {
    throw FileError(shown_error(error.what(), file, file.parent_path()));
  } catch (const std::runtime_error& error) {  // The memory is not enough for a box tree.
    throw FileError(file.string() + ": " + error.what());
  } catch (const std::bad_alloc&) {
    throw FileError(file.string() +
                    ": does not fit into the memory that this process may have; simplify the "
                    "scene, or raise the limit (ulimit -v)");
  }
}

Scene load_scene_and_keep(const std::filesystem::path& file) {
  FileBytes read;
  const FileReadingScope reading({.keep = &read});
  Scene scene = load_scene(file);
  CapturedFiles kept{file.filename().generic_string(), {}};
  const std::filesystem::path folder = captured_name(file.parent_path());
  for (auto& [name, bytes] : read) {
    const std::filesystem::path inside = std::filesystem::path(name).lexically_relative(folder);
    kept.files.emplace(folder.empty() || inside.empty() ? name : inside.generic_string(),
                       std::move(bytes));
  }
  scene.keep_files(std::make_shared<const CapturedFiles>(std::move(kept)));
  return scene;
}

Scene load_kept_scene(const CapturedFiles& files) {
  const FileReadingScope reading({.given = &files.files});
  Scene scene = load_scene(files.main);
  scene.keep_files(std::make_shared<const CapturedFiles>(files));
  return scene;
}

}  // namespace feltwire
