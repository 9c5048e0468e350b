// Adds a bounding law (a struct and an entry in the registry) and tests this law.
//
//   my_bound                 exit status 1 if the law breaks its promise
//   my_bound --wrong-sign    a law with a wrong sign, which the tests must reject
//
// The law stores the work of the hand on the port and the energy that the device's damping
// dissipates. The law limits the force so that the hand can take back at most the stored energy.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <feltwire/sim/studies/bound/compare.hpp>
#include <feltwire/sim/studies/bound/extremes.hpp>
#include <string_view>

using namespace feltwire;

/// The energy store of a port, for forces or for torques. All directions have one common store.
struct Port {
  static constexpr double kLeast = 1e-290;  // [J] a smaller double loses digits
  double damping, period;                   // b [N s/m], T [s]
  double sign = 1.0;                        // energy flow into the port: -sign f.dx
  double energy = 0.0;                      // [J] below zero: a debt
  Vec3 held = Vec3::Zero();                 // f(n-1), on the hand

  /// The share of the wanted force that the store covers, after a movement dx in `time` [s].
  double share(const Vec3& wanted, const Vec3& dx, double time) noexcept {
    energy += damping / time * dx.squaredNorm() - sign * held.dot(dx);
    const double allowed = std::sqrt(4.0 * damping / period * std::max(0.0, energy - kLeast));
    return std::min(1.0, allowed / std::max(wanted.norm(), 1e-300));
  }
  /// Limits the store to S(f) = |f|^2 T / (4 b), the most energy that the hand can take back.
  void hold(const Vec3& force) noexcept {
    held = force;
    energy = std::min(energy, force.squaredNorm() * period / (4.0 * damping));
  }
};

struct MyLaw {
  Port force, torque;

  Command step(const BoundingStep& s) noexcept {
    const double f = force.share(s.command.force(), s.displacement, s.hold_time);
    const double t = torque.share(s.command.torque, s.rotation, s.hold_time);
    const Command rendered{f * s.command.elastic, f * s.command.frictional, t * s.command.torque};
    set_held(rendered);
    return rendered;
  }
  /// Takes the force that the device held, which a limit, a fade or a skipped write can change.
  void set_held(const Command& held) noexcept {
    force.hold(held.force());
    torque.hold(held.torque);
  }
};

template <int kSign>
BoundingLaw my_law(const BoundingConfig& c) {
  return MyLaw{{c.damping.least(), c.period, kSign},
               {c.rotational_damping.least(), c.period, kSign}};
}

int main(int argc, char** argv) try {
  const bool wrong = argc == 2 && std::string_view(argv[1]) == "--wrong-sign";
  if (argc > 1 && !wrong) return std::fprintf(stderr, "usage: my_bound [--wrong-sign]\n"), 2;
  add_bounding_method({.name = "my_bound",
                       .summary = "one store of energy for all directions",
                       .make = wrong ? my_law<-1> : my_law<1>,
                       .promise = Promise::port,
                       .kept_despite = kAllFaults,
                       .admits_reduction = true});
  const auto judged = run_extremes(1.0, 10, {"contact_frame", "my_bound"});
  const Method mine{"my_bound", [](BoundingConfig& c) { c.mode = "my_bound"; }};
  const auto rows = compare(compare_tasks(), {method("none"), method("contact_frame"), mine}, {});
  std::printf("%s\n%s", extremes_table(judged).c_str(), compare_table(rows).c_str());
  return all_passed(judged) ? 0 : 1;
} catch (const std::exception& error) {
  return std::fprintf(stderr, "my_bound: %s\n", error.what()), 1;
}
