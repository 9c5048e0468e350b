#pragma once
// Scripts of the property tests: what a hand, a scene and a network do, tick by tick. RapidCheck
// makes them at random and shrinks one that breaks a promise to the few ticks that matter.
//
// ctest runs every property with the seed 1, and once more with a random seed that is printed
// (tests/CMakeLists.txt). Others by hand:
//   RC_PARAMS="seed=7 max_success=2000" build/release/tests/core/property_test

// In this order: RapidCheck's header uses what GoogleTest's defines.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "tests/core/support.hpp"

namespace feltwire::test {

/// The movement of the hand until the next tick. `displacement` and `rotation` of the tick are
/// added to it.
enum class Hand : std::uint8_t {
  wanders,      // only that
  takes,        // `share` of the movement that takes most energy from what is held; < 0 presses
  takes_along,  // the part of it along the elastic force held
  takes_across,
  trembles  // to and fro along z by `share` times Script::tremble, alternately: the sampled
            // spring's worst
};

struct Tick {
  Hand hand = Hand::wanders;
  double share = 1.0;
  Vec3 displacement = Vec3::Zero(), rotation = Vec3::Zero();  // [m], [rad]
  bool wall = false;  // the scene sends what its wall answers at the hand instead of `command`
  Command command{};
  int age = 0;               // [ticks] of the command that is used: lost, late, twice, out of order
  double hold = 1.0;         // [T] that the force before this tick was held
  double kept = 1.0;         // share of what is rendered that the device holds
  Vec3 bent = Vec3::Zero();  // a unit vector: the device holds that much along it instead
  bool skipped = false;      // the device goes on holding the force before
  bool lost = false;         // the bound is told that the movement is not a number
  int law = -1;              // a new bound, of this number, takes over at this tick; -1: none

  friend bool operator==(const Tick&, const Tick&) = default;
};

struct Script {
  double stiffness = 0.0;  // [N/m] of the scene's wall z < 0
  double friction = 0.0;   // of it, coefficient
  double tremble = 1e-4;   // [m]
  std::vector<Tick> ticks;
};

/// The events that may occur in a script.
struct ScriptOptions {
  double longest_hold = 1.0;  // [T]
  bool reduces = false;       // the device holds less than it is told
  bool bends = false;         // or as much in another direction
  bool skips = false;         // or what it held before
  bool loses = false;         // movements
  bool greedy = true;
  int laws = 1;          // more than one: they change at run time
  double largest = 3.0;  // decades of the commands, 10^-3 to 10^largest [N]
  int longest = 400;     // [ticks]
};

rc::Gen<Script> scripts(const ScriptOptions& options);
/// Symmetric positive definite, of a condition number up to `condition`, its mean near `b`.
rc::Gen<Mat3> random_damping(double b, double condition);
rc::Gen<Mat3> random_orientation();

/// RapidCheck prints counterexamples with it.
void showValue(const Script& script, std::ostream& out);

}  // namespace feltwire::test
