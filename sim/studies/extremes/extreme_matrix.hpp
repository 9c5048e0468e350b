#pragma once
// The cells of a matrix of extremes: a product function under an extreme quantity, judged against a
// closed form or an invariant.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

/// The result of one function under one stress, over all its cases.
struct ExtremeCell {
  std::string stress;     // the extreme quantity; a row of the table
  std::string judged;     // the shape or the function; a column of the table
  std::string reference;  // what the error is measured against, and its unit
  std::uint64_t checks = 0;
  std::uint64_t not_finite = 0;  // results with NaN or Inf
  std::uint64_t over_limit = 0;  // results over the limit of the quantity
  std::uint64_t holes = 0;       // a force or a message that must be there, and is missing
  double error = 0.0;            // worst
  double allowed = 0.0;          // largest error that passes
  double assumed_scale = 1.0;    // as in ExtremeMatrix
  std::string refused = {};      // why the extreme was refused when it was loaded; empty: it ran
  std::string warned = {};       // the warning at load that foretells a failure; empty: none

  /// A cell that ran must have judged something. A refusal names the field that is out of range. A
  /// failure that the loader has warned of passes, if it is no NaN, no Inf and no broken limit.
  bool passed() const {
    if (!refused.empty()) return refused.find(':') != std::string::npos;
    return checks > 0 && not_finite == 0 && over_limit == 0 && (kept() || !warned.empty());
  }
  /// No hole, and no error that is too large.
  bool kept() const { return holes == 0 && error <= allowed; }

  /// Judges one result: whether it is finite, its error (NaN counts as not finite), and whether it
  /// keeps its limit.
  void judge(bool finite, double found_error, bool within_limit = true);
};

/// A matrix of extremes: its rows are stresses, its columns the judged functions.
struct ExtremeMatrix {
  std::string part;   // "contact"
  std::string title;  // the head of its table
  /// The closed forms, and the limits of a robot, are wrong by this factor: above 1 the matrix must
  /// fail, which shows that it can.
  double assumed_scale = 1.0;
  std::vector<ExtremeCell> cells = {};

  bool passed() const;
};

/// "size 1e-09 m"
std::string stress_name(const char* quantity, double value, const char* unit);

/// The worst error of each cell, for people: a line for each stress, and a line for each failure
/// and each refusal.
std::string extreme_matrix_table(const ExtremeMatrix& matrix);

/// Writes extremes_PART.csv and extremes_PART.json to `directory` (created). The same build writes
/// the same bytes. Throws std::runtime_error when something cannot be written.
void write_extreme_matrix(const std::filesystem::path& directory, const ExtremeMatrix& matrix);

}  // namespace feltwire
