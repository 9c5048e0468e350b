#pragma once
// Every bounding method at the limits of the number range: stiffness, period, movement, force,
// damping, place, hold times, NaN and Inf; in double and in float.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/studies/bound/passivity_claims.hpp"

namespace feltwire {

/// The result of one method in one arithmetic under one stress, over all its hands.
struct ExtremeOutcome {
  std::uint64_t steps = 0;
  std::uint64_t rendering = 0;     // steps with a force
  std::uint64_t nan = 0, inf = 0;  // steps that rendered one
  std::uint64_t over_limit = 0;    // steps whose force exceeded the limit by more than 8 epsilon
  std::uint64_t not_refused = 0;   // steps that rendered a force although an input was not a number
  double energy_error = 0.0;       // worst missing part of the promised energy, over all exchanged
  double rounding = 0.0;           // the part that rounding may explain (PromiseLedger)
  bool broken = false;             // more was missing than rounding can explain
  bool passed() const {
    return nan == 0 && inf == 0 && over_limit == 0 && not_refused == 0 && !broken;
  }
};

struct ExtremeRow {
  std::string stress;       // the extreme quantity
  std::string_view method;  // a bounding mode
  Promise promise = Promise::none;
  ExtremeOutcome in_double, in_float;
  bool passed() const { return in_double.passed() && in_float.passed(); }
};

/// Runs everything: each stress against each method. Hands that know the force held and take all
/// they can, and hands that move at random; and simulated hands at a scene's wall.
/// `assumed_damping` is the damping that the bounds are told over the one the device has: above 1
/// the bounds are wrong and the rows must fail, which shows that they can. `hands` is how many
/// hands each stress sends, five kinds in turn. `methods` are names of the registry; one that was
/// added to it is judged in double only. Throws std::invalid_argument when the numbers are not
/// finite and above zero, or there is no such method.
std::vector<ExtremeRow> run_extremes(
    double assumed_damping = 1.0, int hands = 10,
    const std::vector<std::string_view>& methods = bounding_method_names());

/// Whether every row passed: no NaN, no Inf, no force over the limit, every promise kept.
bool all_passed(const std::vector<ExtremeRow>& rows);

/// Writes extremes.csv and extremes.json to `directory` (created). The same build writes the same
/// bytes. Throws std::runtime_error when something cannot be written.
void write_extremes(const std::filesystem::path& directory, const std::vector<ExtremeRow>& rows);
/// Draws extremes.png from extremes.csv in `directory`. Throws std::runtime_error when it cannot be
/// drawn.
void draw_extremes(const std::filesystem::path& directory, const std::vector<ExtremeRow>& rows);

/// The worst relative energy error of every row, for people: a table for each arithmetic.
std::string extremes_table(const std::vector<ExtremeRow>& rows);

}  // namespace feltwire
