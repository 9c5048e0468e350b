#pragma once
// The facts about a scene that the costs and the feel of a session depend on.

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace feltwire::advise {

/// A place of contact: a point of a surface, and the outward normal there.
struct Place {
  Vec3 point = Vec3::Zero();    // [m] world
  Vec3 normal = Vec3::UnitZ();  // unit
  std::string object = {};      // its name
  Material material = {};       // of the object
};

struct SceneFacts {
  std::string name;
  std::vector<Place> materials;  // each material once, the stiffest first; place: where known
  std::size_t objects = 0;
  std::size_t triangles = 0;       // in all meshes
  std::size_t geometry_bytes = 0;  // of meshes and grids
  std::size_t grids = 0, meshes = 0;
  std::size_t meshes_beyond_travel = 0;  // meshes that a client cannot fetch in full
  std::size_t moving = 0;                // objects that move
  std::size_t points = 0;                // of the tool with the most, which has a body; 0: none
  bool polygons = false;                 // a tool touches with polygons
  double tick = 0.0;                     // [s] of moving bodies; 0: nothing moves
  bool friction = false, guides = false;
  double stiffest = 0.0;  // [N/m] of a material or guide
};

/// Reads the facts. Throws std::invalid_argument for a scene in which nothing can be pressed.
SceneFacts facts_of(const Scene& scene);

/// The bytes of the local model at a place, its surfaces and the computing time there, measured on
/// this machine.
struct PlaceCost {
  std::size_t patches = 0;          // surfaces in the model
  double reach = 0.0;               // [m] of the model
  std::size_t reply_bytes = 0;      // payload of a reply with this model
  double touch = 0.0, model = 0.0;  // [s] of one call each
};
/// `rotation`: torque travels too. Precondition: the tool of the scene has no body.
PlaceCost cost_at(const Scene& scene, const Place& place, bool modelled, bool rotation = false);

}  // namespace feltwire::advise
