#pragma once
// Scripts of the property tests: what a hand, a scene and a network do, tick by tick. RapidCheck
// makes random scripts and shrinks a script that breaks a promise to the few ticks that matter.
//
// ctest runs every property with the seed 1, and once more with a random seed that is printed
// (tests/CMakeLists.txt). To run with others:
//   RC_PARAMS="seed=7 max_success=2000" build/release/tests/core/property_test

// Keep this order: RapidCheck's header uses what GoogleTest's defines.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "tests/core/support.hpp"

namespace feltwire::test {

/// The movement of the hand until the next tick. The tick's own `displacement` and `rotation` are
/// added.
enum class Hand : std::uint8_t {
  wanders,      // the added movement only
  takes,        // `share` of the movement that takes most energy from the held force; < 0 presses
  takes_along,  // its part along the held elastic force
  takes_across,
  trembles  // to and fro along z by `share` times Script::tremble, alternately: the sampled
            // spring's worst
};

struct Tick {
  Hand hand = Hand::wanders;
  double share = 1.0;
  Vec3 displacement = Vec3::Zero(), rotation = Vec3::Zero();  // [m], [rad]
  bool wall = false;  // the scene sends its wall's answer instead of `command`
  Command command{};
  int age = 0;               // [ticks] of the used command: lost, late, twice, out of order
  double hold = 1.0;         // [T] that the previous force was held
  double kept = 1.0;         // share of the rendered force that the device holds
  Vec3 bent = Vec3::Zero();  // a unit vector: the device holds the force along it instead
  bool skipped = false;      // the device keeps the previous force
  bool lost = false;         // the bound is told that the movement is not a number
  int law = -1;              // number of the new bound that takes over at this tick; -1: none

  friend bool operator==(const Tick&, const Tick&) = default;
};

struct Script {
  double stiffness = 0.0;  // [N/m] of the scene's wall z < 0
  double friction = 0.0;   // the wall's friction coefficient
  double tremble = 1e-4;   // [m]
  std::vector<Tick> ticks;
};

/// The events that may occur in a script.
struct ScriptOptions {
  double longest_hold = 1.0;  // [T]
  bool reduces = false;       // the device holds less than it is told
  bool bends = false;         // or holds it in another direction
  bool skips = false;         // or keeps its previous force
  bool loses = false;         // movements get lost
  bool greedy = true;
  int laws = 1;          // more than one: the law changes at run time
  double largest = 3.0;  // decades of the commands, 10^-3 to 10^largest [N]
  int longest = 400;     // [ticks]
};

rc::Gen<Script> scripts(const ScriptOptions& options);
/// Symmetric positive definite, condition number up to `condition`, largest eigenvalue `b`.
rc::Gen<Mat3> random_damping(double b, double condition);
rc::Gen<Mat3> random_orientation();

/// RapidCheck prints counterexamples with this function.
void showValue(const Script& script, std::ostream& out);

}  // namespace feltwire::test
