#include "core/dynamics/mujoco_geoms.hpp"

#include <mujoco/mujoco.h>

#include <cstdlib>
#include <map>
#include <tuple>

#include "core/base/numeric.hpp"
#include "core/convex/convex_hull.hpp"
#include "core/dynamics/mass_properties.hpp"
#include "core/dynamics/mujoco_text.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire::mujoco {
namespace {

/// Returns true if a mesh still has a volume in single precision. MuJoCo refuses a mesh without
/// volume.
bool is_solid_in_float(const std::vector<Vec3>& points) {
  constexpr double kLeastVolume = 2.0 * mjMINVAL;  // [m^3]
  // Least volume as a share of the cube of the size. It is larger than the rounding errors of
  // single precision.
  constexpr double kThin = 1e-6;
  std::vector<Vec3> rounded;
  Bounds bounds;
  for (const Vec3& p : points) {
    rounded.push_back(p.cast<float>().cast<double>());
    bounds.add(rounded.back());
  }
  const auto hull = convex_hull(rounded);
  const double size = (bounds.most - bounds.least).maxCoeff();
  return hull && hull->volume > std::max(kLeastVolume, kThin * size * size * size);
}

std::vector<PhysicsGeom> made_geoms(const Object& object, const ConvexSolids* solids) {
  const TriangleMesh* mesh = triangles_of(object.shape);
  if (mesh == nullptr)
    return on_primitive(
        object.shape, [&](const auto& solid) { return solid.geoms(object.felt_from); },
        [] { return std::vector<PhysicsGeom>(); });
  if (object.felt_from == Side::inside || !(mass_properties(object.shape).volume > 0.0)) return {};
  const Pose middle{mesh->origin(), Quaternion::Identity()};
  std::vector<PhysicsGeom> geoms;
  if (solids == nullptr) {
    geoms.push_back({.pose = middle, .hull = mesh->vertices()});
    return geoms;
  }
  for (const std::vector<Vec3>& solid : *solids)
    if (solids->size() == 1 || is_solid_in_float(solid))
      geoms.push_back({.pose = middle, .hull = solid});
  return geoms;
}

/// Returns the number in the name of a geom. The object has `count` geoms.
std::string number_of(std::size_t object, std::size_t index, std::size_t count) {
  return std::to_string(object) + (count > 1 ? "_" + std::to_string(index) : "");
}

/// Returns the shape attributes of a geom. `name` is the mesh of a geom that is a convex hull.
std::string geom_shape(const PhysicsGeom& geom, const std::string& name) {
  const auto sized = [](const char* type, const std::string& size) {
    return attribute("type", type) + attribute("size", size);
  };
  const Vec3& s = geom.size;
  switch (geom.kind) {
    case PhysicsGeom::Kind::plane:
      return sized("plane", "0 0 1");
    case PhysicsGeom::Kind::sphere:
      return sized("sphere", number_text(s.x()));
    case PhysicsGeom::Kind::box:
      return sized("box", mujoco::text(s));
    case PhysicsGeom::Kind::capsule:
      return sized("capsule", number_text(s.x()) + " " + number_text(s.y()));
    case PhysicsGeom::Kind::cylinder:
      return sized("cylinder", number_text(s.x()) + " " + number_text(s.y()));
    case PhysicsGeom::Kind::hull:
      break;
  }
  return attribute("type", "mesh") + attribute("mesh", name);
}

Pose operator*(const Pose& a, const Pose& b) {
  return {a.position + a.orientation * b.position, a.orientation * b.orientation};
}

}  // namespace

const TriangleMesh* triangles_of(const Shape& shape) {
  const auto* mesh = std::get_if<Mesh>(&shape);
  return mesh != nullptr ? &mesh->surface->mesh() : nullptr;
}

CollisionGeoms::CollisionGeoms(const std::vector<Object>& objects, const ObjectSolids& solids) {
  std::map<std::tuple<const TriangleMesh*, const ConvexSolids*, Side>, std::size_t> known;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const TriangleMesh* mesh = triangles_of(objects[i].shape);
    const ConvexSolids* own = solids.empty() ? nullptr : solids[i].get();
    const auto first = mesh == nullptr
                           ? known.end()
                           : known.try_emplace({mesh, own, objects[i].felt_from}, i).first;
    owner_.push_back(first == known.end() ? i : first->second);
    geoms_.push_back(owner_[i] == i ? made_geoms(objects[i], own) : std::vector<PhysicsGeom>());
  }
}

std::size_t CollisionGeoms::count() const {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < geoms_.size(); ++i) sum += geoms_of(i).size();
  return sum;
}

bool CollisionGeoms::is_exact(std::size_t object) const {
  const auto& geoms = geoms_of(object);
  return geoms.size() == 1 && geoms[0].kind != PhysicsGeom::Kind::hull;
}

std::string CollisionGeoms::meshes() const {
  std::string xml;
  for (std::size_t i = 0; i < geoms_.size(); ++i) {
    for (std::size_t k = 0; k < geoms_[i].size(); ++k) {
      if (geoms_[i][k].kind != PhysicsGeom::Kind::hull) continue;
      std::string vertices;
      for (const Vec3& v : geoms_[i][k].hull) vertices += mujoco::text(v) + " ";
      xml += "<mesh" + attribute("name", "m" + number_of(i, k, geoms_[i].size())) +
             attribute("vertex", vertices) + "/>\n";
    }
  }
  return xml;
}

std::string CollisionGeoms::text(std::size_t object, const Pose& pose, const Material& material,
                                 const std::string& more) const {
  // MuJoCo has one friction coefficient per contact, so use the dynamic friction. A contact without
  // friction is one-dimensional.
  const double friction = material.dynamic_friction;
  const auto& geoms = geoms_of(object);
  std::string xml;
  for (std::size_t k = 0; k < geoms.size(); ++k)
    xml += "<geom" + attribute("name", "o" + number_of(object, k, geoms.size())) +
           geom_shape(geoms[k], "m" + number_of(owner_[object], k, geoms.size())) +
           place(geoms[k].pose ? pose * *geoms[k].pose : pose) +
           (friction > 0.0
                ? attribute("condim", "3") + attribute("friction", number_text(friction) + " 0 0")
                : attribute("condim", "1") + attribute("friction", "0 0 0")) +
           more + "/>\n";
  return xml;
}

std::vector<int> objects_of_geoms(const mjModel& model) {
  std::vector<int> object_of;
  for (int g = 0; g < model.ngeom; ++g) {
    const char* name = mj_id2name(&model, mjOBJ_GEOM, g);
    object_of.push_back(name == nullptr ? -1 : std::atoi(name + 1));
  }
  return object_of;
}

}  // namespace feltwire::mujoco
