#include "core/scene_file/read_bodies.hpp"

#include <cmath>

#include "core/arm/driven_arm.hpp"
#include "core/dynamics/mujoco_compile.hpp"
#include "core/dynamics/mujoco_mjcf.hpp"
#include "core/scene_file/read_parts.hpp"
#include "core/scene_file/read_values.hpp"
#include "core/scene_file/shown_error.hpp"

namespace feltwire {
namespace {

Body read_body(const scene_file::Body& given) {
  Body body;
  body.name = given.name()->str();
  body.pose = pose_of(given);
  body.joint = given.joint() == scene_file::Joint::hinge   ? Joint::hinge
               : given.joint() == scene_file::Joint::slide ? Joint::slide
                                                           : Joint::free;
  if (!std::isnan(given.mass())) body.mass = given.mass();
  if (!std::isnan(given.density())) body.density = given.density();
  body.collides = given.collides();
  if (const auto* axis = given.axis()) body.axis = vector(*axis);
  if (const auto* range = given.range()) {
    body.low = range->low();
    body.high = range->high();
  }
  body.stiffness = given.stiffness();
  body.rest = given.rest();
  body.damping = given.damping();
  body.friction = given.friction();
  return body;
}

struct ReadBodies {
  Names names;
  std::vector<Body> all;
  std::vector<bool> fixed;
};

ReadBodies read_list(const JsonDocument& document, const scene_file::Scene& scene) {
  ReadBodies bodies{Names(document, "bodies"), {}, {}};
  if (scene.bodies() == nullptr) return bodies;
  for (const scene_file::Body* given : *scene.bodies()) {
    const std::string path = element("bodies", bodies.all.size());
    Body body = read_body(*given);
    bodies.names.add(body.name);
    bodies.fixed.push_back(given->joint() == scene_file::Joint::fixed);
    // A fixed body needs no mass, so give it any valid mass.
    if (bodies.fixed.back() && !body.mass && !body.density) body.mass = 1.0;
    require(document, path, check(body));
    make_unit(body.pose.orientation);
    bodies.all.push_back(std::move(body));
  }
  return bodies;
}

/// Copies the moving bodies to `moving`. Returns the index of each body in `moving`, or -1 for a
/// fixed body.
std::vector<int> numbered(ReadBodies& bodies, std::vector<Body>& moving) {
  std::vector<int> number;
  for (std::size_t i = 0; i < bodies.all.size(); ++i) {
    number.push_back(bodies.fixed[i] ? -1 : static_cast<int>(moving.size()));
    if (!bodies.fixed[i]) moving.push_back(bodies.all[i]);
  }
  return number;
}

/// Removes the prefix from an error of compile(), because the caller's error already names the
/// field.
std::string without_prefix(const std::string& words) {
  for (const char* prefix : {"bodies: ", "scene: bodies: "})
    if (words.starts_with(prefix)) return words.substr(std::string_view(prefix).size());
  return words;
}

MechanismOptions read_options(const JsonDocument& document, const scene_file::Scene& scene) {
  MechanismOptions options;
  if (const auto* gravity = scene.gravity()) options.gravity = vector(*gravity);
  options.tick = scene.tick();
  require(document, "", check(options));
  return options;
}

}  // namespace

ReadMechanism read_bodies(const JsonDocument& document, const scene_file::Scene& scene,
                          const std::filesystem::path& folder, std::vector<Object>& objects) {
  const MechanismOptions options = read_options(document, scene);
  ReadBodies bodies = read_list(document, scene);
  std::vector<Body> moving;
  const std::vector<int> number = numbered(bodies, moving);

  std::vector<int> body_of(objects.size(), -1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto* name = scene.objects()->Get(static_cast<flatbuffers::uoffset_t>(i))->body();
    if (name == nullptr) continue;
    const auto at = bodies.names.find(name->str());
    if (!at)
      document.fail(element("objects", i) + ".body",
                    "there is no body '" + name->str() + "'; add it to bodies");
    const Pose& frame = bodies.all[*at].pose;
    Pose& pose = objects[i].pose;
    pose = {frame.position + frame.orientation * pose.position,
            frame.orientation * pose.orientation};
    body_of[i] = number[*at];
  }
  if (moving.empty()) return {};
  CollisionParts parts = read_collision_parts(document, scene, folder, objects, body_of, moving);
  try {
    return {compile(objects, body_of, moving, options, std::move(parts.of_object)),
            std::move(parts.notes), std::move(parts.warnings)};
  } catch (const std::invalid_argument& error) {
    document.fail("bodies", without_prefix(error.what()));
  }
}

std::shared_ptr<const Mechanism> read_mjcf(const JsonDocument& document,
                                           const scene_file::Scene& scene,
                                           const std::filesystem::path& folder,
                                           const std::vector<RemoteSeat>& seats,
                                           const FindMaterial& find_material,
                                           std::vector<Object>& objects) {
  const scene_file::Mjcf& given = *scene.mjcf();
  if (scene.objects() != nullptr && scene.objects()->size() > 0)
    document.fail("objects",
                  "stand beside an mjcf, whose bodies would not see them; put them into "
                  "the MJCF file");
  if (scene.bodies() != nullptr && scene.bodies()->size() > 0)
    document.fail("bodies", "stand beside an mjcf; put them into the MJCF file");
  if (scene.gravity() != nullptr)
    document.fail("gravity", "is the MJCF file's own to say; remove it");
  MjcfMaterials materials;
  materials.other_name = given.material()->str();
  materials.other = find_material("mjcf", materials.other_name);
  if (given.materials() != nullptr)
    for (const scene_file::MjcfMaterial* m : *given.materials())
      materials.named.push_back(
          {m->name()->str(),
           find_material("mjcf." + element("materials", materials.named.size()),
                         m->material()->str()),
           m->material()->str()});
  const MechanismOptions options = read_options(document, scene);
  const std::filesystem::path file = folder / given.file()->str();
  try {
    return load_mjcf(file, materials, options.tick, objects,
                     [&](const mjModel_& model, double* coordinates) {
                       for (const RemoteSeat& seat : seats)
                         if (seat.arm) go_home(model, file.string(), *seat.arm, coordinates);
                     });
  } catch (const FileError& error) {
    document.fail("mjcf.file", shown_mjcf_error(error, file, folder));
  }
}

}  // namespace feltwire
