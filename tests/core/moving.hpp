#pragma once
// Scenes in which something moves, for tests.

#include <string>
#include <vector>

#include "core/dynamics/mujoco_compile.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/scene.hpp"

namespace feltwire::test {

inline Object object(const char* name, const Shape& shape, const Material& material = {},
                     const Vec3& position = Vec3::Zero()) {
  Object o;
  o.name = name;
  o.shape = shape;
  o.material = material;
  o.pose.position = position;
  return o;
}

inline Body body(const char* name, double mass, const Vec3& position = Vec3::Zero()) {
  Body b;
  b.name = name;
  b.mass = mass;
  b.pose.position = position;
  return b;
}

inline Scene moving(std::vector<Object> objects, const std::vector<int>& body_of,
                    const std::vector<Body>& bodies, const MechanismOptions& options = {}) {
  const auto mechanism = compile(objects, body_of, bodies, options);
  Scene scene("moving", objects);
  scene.set_mechanism(mechanism);
  return scene;
}

inline const MechanismOptions kWeightless{.gravity = Vec3::Zero()};

/// A ball so light that each tick the hand's spring throws it farther than it was deep.
inline Scene explosive(double mass = 1e-4) {
  return moving({object("table", Plane{}, {.stiffness = 1000}),
                 object("ball", Sphere{0.03}, {.stiffness = 1e7}, {0, 0, 0.2})},
                {-1, 0}, {body("ball", mass, {0, 0, 0.2})}, kWeightless);
}

/// A hand in a world: each step touches, pushes and runs a tick.
struct Hand {
  explicit Hand(World& in) : world(in), memory(in.view().memory()), contacts(in.contact_state()) {}
  Command touch(const Vec3& position, const Vec3& velocity = Vec3::Zero()) {
    return world.touch({position, velocity}, memory, contacts);
  }
  Command step(const Vec3& position) {
    const Command felt = touch(position);
    world.push(contacts, memory, 1.0);
    world.step();
    return felt;
  }
  World& world;
  TouchMemory memory;
  BodyContactState contacts;
};

/// [N m s] about the world's origin, of a ball that is the only object: orbit and spin. A ball has
/// no gyroscopic part.
inline Vec3 angular_momentum_of_ball(const World& world, double mass, double radius) {
  const Vec3 centre = world.objects()[0].pose.position;
  const Vec3 velocity = world.velocity_at(0, centre);
  const Vec3 spin = world.velocity_at(0, centre + Vec3::UnitX()) - velocity;
  const Vec3 spin_y = world.velocity_at(0, centre + Vec3::UnitY()) - velocity;
  const Vec3 omega(spin_y.z(), -spin.z(), spin.y());
  return mass * centre.cross(velocity) + 0.4 * mass * radius * radius * omega;
}

}  // namespace feltwire::test
