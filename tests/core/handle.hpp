#pragma once
// A handle in continuous time, under a held force and a malicious hand: the physics that the
// account claims to bound, integrated exactly between the hand's changes.

#include <algorithm>
#include <cmath>

#include "core/bounding/reachable_displacement.hpp"
#include "tests/core/support.hpp"

namespace feltwire::test {

/// A point mass with viscous and dry friction. Within a step the applied force is constant and the
/// motion under it exact; friction acts as an impulse against the velocity at the end of each step.
struct Handle {
  double mass = 0.075;   // [kg]
  double viscous = 0.0;  // [N s/m]
  double dry = 0.0;      // [N]
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();

  void move(const Vec3& force, double time) {
    const Vec3 acceleration = force / mass;
    position += velocity * time + 0.5 * time * time * acceleration;
    velocity += time * acceleration;
    velocity *= std::exp(-viscous * time / mass);
    const double speed = velocity.norm(), braked = dry * time / mass;
    velocity *= speed > braked ? 1.0 - braked / speed : 0.0;
  }
};

/// A point as an encoder shows it: each axis rounded to a multiple of q.
inline Vec3 encoded(const Vec3& x, double q) {
  return q > 0.0 ? Vec3((x / q).array().round() * q) : x;
}

/// How a hand acts during a sample.
enum class Grip { pull, push, throw_then_pull, noise, swing, none };

/// A hand's force, at most `strength`, at `now` (0 to 1) of the sample while `held` acts.
inline Vec3 hand_force(Grip grip, Random& random, const Vec3& held, double strength, double now) {
  const Vec3 u = held.norm() > 0.0 ? Vec3(held.normalized()) : Vec3::UnitX();
  switch (grip) {
    case Grip::pull:  // with the force: takes its energy
      return strength * u;
    case Grip::push:
      return -strength * u;
    case Grip::throw_then_pull:
      return now < 0.5 ? Vec3(-strength * u) : Vec3(strength * u);
    case Grip::noise:
      return strength * random.uniform(0.0, 1.0) * random.direction();
    case Grip::swing:
      return strength * (random.chance(0.5) ? 1.0 : -1.0) * u;
    case Grip::none:
      break;
  }
  return Vec3::Zero();
}

inline Grip any_grip(Random& random) {
  constexpr Grip kAll[] = {Grip::pull,  Grip::push,  Grip::throw_then_pull,
                           Grip::noise, Grip::swing, Grip::none};
  return kAll[static_cast<int>(random.uniform(0.0, 5.999))];
}

}  // namespace feltwire::test
