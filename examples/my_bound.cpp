// Adds a bounding law to the registry and tests it. A bounding law keeps the device passive.
//
//   my_bound                 exit status 1 if the law fails a test
//   my_bound --wrong-sign    a law with a wrong sign, which must fail
//
// The law stores the work of the hand on the device and the energy that the device's damping
// dissipates. It limits the force so that the hand can take back at most the stored energy.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <feltwire/sim/studies/bound/compare.hpp>
#include <feltwire/sim/studies/bound/extremes.hpp>
#include <string_view>

using namespace feltwire;

/// The energy store for forces, or for torques. All directions share it.
struct Port {
  static constexpr double kLeast = 1e-290;  // [J] reserve, because tiny doubles lose digits
  double damping, period;                   // damping b [N s/m] of the device, servo period T [s]
  double sign = 1.0;                        // factor of the hand's work -f.dx; -1 is wrong
  double energy = 0.0;                      // [J] stored energy; may be negative
  Vec3 held = Vec3::Zero();                 // f(n-1) [N], force on the hand since the last step

  /// Adds the energy of a movement dx in `time` [s]. Returns the allowed share of `wanted`.
  double share(const Vec3& wanted, const Vec3& dx, double time) noexcept {
    energy += damping / time * dx.squaredNorm() - sign * held.dot(dx);
    const double allowed = std::sqrt(4.0 * damping / period * std::max(0.0, energy - kLeast));
    return std::min(1.0, allowed / std::max(wanted.norm(), 1e-300));
  }
  /// Sets the held force f. Limits `energy` to |f|^2 T / (4 b), the most that f can give the hand.
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
  /// Sets the force that the device really holds, after a force limit, a fade or a skipped write.
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
