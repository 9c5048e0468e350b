#pragma once
// feltwire's own law with the simulated arm as its follower, in three dimensions and virtual time.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire::teleop::with_arm {

struct ArmCase {
  std::string task = "press";  // press, again, slide, sphere, lift, peg
  double round_trip = 0.1;     // [s]
  double jitter = 0.0;         // [s] of each way
  double loss = 0.0;           // share of each way
  std::uint64_t seed = 1;      // of the network and the sensor's noise
};

/// The results of a run. Means are over the task's window, in which the hand rests or slides
/// evenly.
struct ArmMeasured {
  /// [N] The force that the hand intends, or the weight that it lifts. Not of `peg`.
  std::optional<double> intended;
  /// [N] The largest force between the tool and its surroundings; `lift`: before the box is put
  /// down.
  double peak = 0.0;
  std::optional<double> set_down;  // [N] the same while the box is put down and released
  double robot_force = 0.0;        // [N] mean, of the tool
  double hand_force = 0.0;         // [N] mean, on the hand
  double force_error = 0.0;        // [N] RMS of hand less tool, each along each axis
  double swing = 0.0;              // [m] high-passed RMS of the tool's height
  double flicker = 0.0;            // [N] largest change of the hand's force between two samples
  /// [N] Largest fall of the hand's force within 30 ms while the hand moves in; `again`: the second
  /// time. Not of `lift` and `peg`.
  std::optional<double> fall;
  /// Stiffness of arm and surface that the hand knows, over that of arm and table or sphere. Not of
  /// `lift` and `peg`.
  std::optional<double> displayed;
  double offset = 0.0;             // [m] of the leader's index at the end of the window
  double energy_made = 0.0;        // [J] to the hand beyond burned and pushed
  std::optional<double> lifted;    // [m] mean height of the box above the ground
  std::optional<double> inserted;  // [m] of the peg in its hole, at the end of the window
  bool stopped = false;            // the arm made a protective stop or had a fault
};

struct ArmRow {
  ArmCase made;
  ArmMeasured measured;
};

/// The whole study; quick: one round trip and one link.
std::vector<ArmCase> arm_cases(bool quick);

/// Runs every case; rows in the order of the cases. Deterministic. Throws std::invalid_argument for
/// a task that does not exist.
std::vector<ArmRow> run_arm(const std::vector<ArmCase>& cases);

/// Writes arm.json to `directory` (created). Throws std::runtime_error if it cannot.
void write_arm(const std::filesystem::path& directory, const std::vector<ArmRow>& rows);

/// For people: of each task, round trip and link the median over the seeds, and the worst.
std::string arm_table(const std::vector<ArmRow>& rows);

}  // namespace feltwire::teleop::with_arm
