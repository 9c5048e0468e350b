#include "sim/studies/bound/stress_inputs.hpp"

#include <utility>

namespace feltwire {

std::vector<StressInputs> all_stress_inputs() {
  std::vector<StressInputs> all;
  const auto add = [&](std::string name, auto change) {
    StressInputs stress;
    stress.name = std::move(name);
    change(stress);
    all.push_back(std::move(stress));
  };
  add("an ordinary hand", [](StressInputs&) {});
  add("period 1 us", [](StressInputs& s) { s.period = 1e-6; });
  add("period 0.1 s", [](StressInputs& s) { s.period = 0.1; });
  add("hand still; force held", [](StressInputs& s) { s.still = 0.98; });
  add("movements denormal", [](StressInputs& s) { s.denormal_moves = true; });
  add("movements 1e-300 to 1e3 m",
      [](StressInputs& s) { s.least_move = -300, s.largest_move = 3; });
  add("forces 1e-300 to 1e300 N",
      [](StressInputs& s) { s.least_force = -300, s.largest_force = 300; });
  add("forces 1 MN to 1 TN", [](StressInputs& s) { s.least_force = 6, s.largest_force = 11.99; });
  add("damping 0", [](StressInputs& s) { s.damping = s.rotational_damping = 0.0; });
  add("damping 1e6 N s/m",
      [](StressInputs& s) { s.damping = 1e6, s.rotational_damping = 400.0, s.largest_force = 9; });
  add("damping 1e6; period 1 us", [](StressInputs& s) {
    s.damping = 1e6, s.rotational_damping = 400.0, s.largest_force = 11.9, s.period = 1e-6;
    s.largest_move = 3;
  });
  add("damping by direction 100:1", [](StressInputs& s) {
    s.damping = Mat3{{2.0, 0.3, 0.1}, {0.3, 0.5, 0.02}, {0.1, 0.02, 0.0252}};
    s.rotational_damping = Vec3(1e-3, 1e-4, 1e-5);
  });
  add("1e6 m from the origin", [](StressInputs& s) { s.origin = 1e6; });
  add("limit 0.3 N", [](StressInputs& s) { s.max_force = 0.3; });
  add("fades", [](StressInputs& s) { s.fades = 0.5; });
  add("holds up to 50 T", [](StressInputs& s) { s.longest_hold = 50.0; });
  add("holds to 50 T; writes skipped",
      [](StressInputs& s) { s.longest_hold = 50.0, s.skipped_writes = 0.2; });
  add("NaN; Inf; absurd", [](StressInputs& s) { s.strange_inputs = 0.05, s.max_force = 5.0; });
  add("NaN; Inf; absurd; holds to 5 T",
      [](StressInputs& s) { s.strange_inputs = 0.05, s.max_force = 5.0, s.longest_hold = 5.0; });
  return all;
}

StressedMovement move(int kind, StressRandom& random, const StressInputs& stress,
                      const Command& held, double hold_time, double least, double largest) {
  const auto restless = [&] {
    return StressedMovement{random.vector(least, largest), random.vector(least, largest)};
  };
  if (random.chance(stress.still)) return {};
  if (kind == 4) kind = static_cast<int>(random.below(4));
  if (kind == 3) return restless();
  const auto greediest = [&](const Damping& damping, const Vec3& f) {
    return damping.least() > 0.0 ? Vec3(damping.matrix().inverse() * f * (0.5 * hold_time))
                                 : random.vector(least, largest);
  };
  StressedMovement m{greediest(stress.damping, held.force()),
                     greediest(stress.rotational_damping, held.torque)};
  const Vec3 normal = held.elastic.normalized();
  double share = 1.0;
  if (kind == 0 && random.chance(0.5)) share = random.uniform(0.0, 3.0);
  if (kind == 1 && random.chance(0.5)) share = -random.uniform(0.0, 4.0);
  if (kind == 2 && normal.allFinite()) {
    const Vec3 along = m.displacement.dot(normal) * normal;
    m.displacement = random.chance(0.5) ? along : Vec3(m.displacement - along);
  }
  m.displacement *= share;
  m.rotation *= share;
  // Without a held force, greediest() returns no movement. So sometimes add a movement that does
  // not depend on the force.
  if (random.chance(0.5)) {
    const StressedMovement own = restless();
    m.displacement += own.displacement;
    m.rotation += own.rotation;
  }
  return m;
}

Command command(StressRandom& random, const StressInputs& stress) {
  Command c;
  if (random.chance(0.1)) return c;
  const double lo = stress.least_force, hi = stress.largest_force;
  if (random.chance(0.8)) c.elastic = random.vector(lo, hi);
  if (random.chance(0.8)) c.frictional = random.vector(lo, hi);
  if (random.chance(0.8)) c.torque = random.vector(lo - 2, hi - 2);
  return c;
}

}  // namespace feltwire
