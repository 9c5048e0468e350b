#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "sim/studies/fleet/virtual_fleet.hpp"

namespace feltwire::fleet {

/// The effect of a fault, or of a work, on a fleet.
struct FleetRun {
  std::string name;
  std::uint32_t hands = 0;  // that lost their session, or wanted one
  double last_hand = 0.0;   // [s] from the beginning until the last of them has one
  double rebalanced = 0.0;  // [s] until also all scenes have a standby and no core is overfull
  bool finished = false;    // nothing was left to do at the end
  FleetCounts counts;
  std::vector<std::pair<std::string, std::string>> notes;  // what else was seen
};

struct FleetStudy {
  FleetInputs inputs;
  std::uint32_t hosts = 0, least_hosts = 0;  // least: all scenes just fit, with no host to lose
  std::uint32_t hands = 0;
  double load = 0.0;                            // of the fullest host
  std::size_t scene_record = 0, heartbeat = 0;  // [bytes]
  std::vector<FleetRun> runs;
};

/// The fewest hosts on which placement finds a place for every scene.
std::uint32_t least_hosts(const FleetInputs& inputs);

// Each on a fleet of its own. The directory's leader dies in the same moment if `leader_too`.
FleetRun lose_rack(const FleetInputs& inputs, std::uint32_t hosts, bool leader_too);
FleetRun lose_leader(const FleetInputs& inputs, std::uint32_t hosts);
FleetRun partition(const FleetInputs& inputs, std::uint32_t hosts);
FleetRun restart_all(const FleetInputs& inputs, std::uint32_t hosts);
FleetRun everybody_joins(const FleetInputs& inputs, std::uint32_t hosts);

/// All of them.
FleetStudy run_fleet(const FleetInputs& inputs);

/// The study as text for a terminal.
std::string fleet_table(const FleetStudy& study);
/// Writes fleet.json. Throws std::runtime_error.
void write_fleet(const std::filesystem::path& folder, const FleetStudy& study);

}  // namespace feltwire::fleet
