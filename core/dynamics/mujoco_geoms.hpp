#pragma once
// Internal to core/dynamics: the geoms that bodies collide with, as MJCF. A geom has the name of
// its object: o12, or o12_3 if the object has several; the meshes of hulls are m12 or m12_3.

#include <memory>
#include <string>
#include <vector>

#include "core/dynamics/mujoco_compile.hpp"
#include "core/geometry/primitive.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire::mujoco {

using ObjectSolids = std::vector<std::shared_ptr<const ConvexSolids>>;

/// Null if the object is not a mesh.
const TriangleMesh* triangles_of(const Shape& shape);

/// The geoms of the objects of a scene.
class CollisionGeoms {
 public:
  /// `solids`: as for compile(). It leaves out a solid that is flat in MuJoCo's single precision.
  CollisionGeoms(const std::vector<Object>& objects, const ObjectSolids& solids);

  /// Number of geoms of all objects.
  std::size_t count() const;
  /// Empty: bodies pass through the object.
  bool has(std::size_t object) const { return !geoms_of(object).empty(); }
  /// Whether MuJoCo's own mass of the geoms is that of the object.
  bool is_exact(std::size_t object) const;

  /// The <mesh> elements of all hulls. Objects of the same mesh or the same solids share them.
  std::string meshes() const;
  /// The <geom> elements of an object at `pose` in its body, with `more` attributes.
  std::string text(std::size_t object, const Pose& pose, const Material& material,
                   const std::string& more) const;

 private:
  const std::vector<PhysicsGeom>& geoms_of(std::size_t object) const {
    return geoms_[owner_[object]];
  }

  std::vector<std::vector<PhysicsGeom>> geoms_;  // by object; empty where another one owns them
  std::vector<std::size_t> owner_;               // by object
};

/// The object of each geom by the geom's name; -1: none.
std::vector<int> objects_of_geoms(const mjModel_& model);

}  // namespace feltwire::mujoco
