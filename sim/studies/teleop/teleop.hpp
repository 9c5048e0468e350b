#pragma once
// The results and costs of each law of bilateral teleoperation, over tasks and networks, on one
// bench.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/studies/teleop/tasks.hpp"

namespace feltwire::teleop {

struct TeleopCase {
  std::string law = "feltwire", task = "press_first";
  double round_trip = 0.1;  // [s]
  double jitter = 0.0;      // [s] of each way
  double loss = 0.0;        // share of each way
};

struct TeleopRow {
  TeleopCase made;
  Measured measured;
};

/// All tasks: tasks.hpp has those of one degree of freedom, space_tasks.hpp those of three.
std::vector<std::string_view> task_names();

/// The cases of the whole study; quick: two round trips and two links.
std::vector<TeleopCase> teleop_cases(bool quick);

/// Runs every case; rows in the order of the cases. Deterministic. Throws std::invalid_argument for
/// a law or a task that does not exist.
std::vector<TeleopRow> run_teleop(const std::vector<TeleopCase>& cases);

/// Writes teleop.json, teleop.csv and teleop.png to `directory` (created). Throws
/// std::runtime_error if something cannot be written or drawn.
void write_teleop(const std::filesystem::path& directory, const std::vector<TeleopRow>& rows);

/// For people: the results of each law over a perfect link and over a bad one.
std::string teleop_table(const std::vector<TeleopRow>& rows);

}  // namespace feltwire::teleop
