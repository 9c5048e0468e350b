#pragma once
// A user's own scene, network and device: every bounding method over it, side by side, in whole
// sessions in virtual time.

#include <filesystem>
#include <string>
#include <vector>

#include "sim/measure/network_run.hpp"

namespace feltwire {

struct OverLinkTask {
  HandTask hand;           // the place and movement of its press
  TwoWayLinkOptions link;  // the network
  DeviceSpec device;
  Plant plant = {};       // of the device, which the client is not told
  double rate = 1000.0;   // [Hz] of the servo
  double duration = 4.0;  // [s]
};

struct OverLinkRow {
  std::string label;      // of the table: the method, with "+ local model" if the surfaces travel
  bool research = false;  // only for comparison; a user chooses from the others
  double oscillation = 0.0;  // [m] RMS of the axis that shakes most, over the second half, less a
                             // centred moving average of 51 ms
  double energy_made = 0.0;  // [J] the largest energy of the hand beyond the energy that the device
                             // burned, over the true displacements; 0 is passive. With a plant that
                             // of the true motor force
  double felt = 0.0;         // force on the hand over the scene's at the true position, both summed
  double error = 0.0;        // [N] RMS of the two's difference
  double direction_error = 0.0;  // [rad] mean angle between the two
};

/// A press of `force` [N] at the scene's start, by a hand with our usual stiffness.
HandTask press_at_start(const Scene& scene, double force);

/// The reference (no network, no bound, 10 kHz), then one row a method, in the order of the table.
/// The runs share the machine's cores; deterministic.
/// Throws std::invalid_argument if a session refuses it, for example for a tool with a body.
std::vector<OverLinkRow> run_over_link(const Scene& scene, const OverLinkTask& task);

/// The rows as a table for people, with the result in words.
std::string over_link_table(const std::vector<OverLinkRow>& rows);

/// Writes methods_over_link.csv and .json to `directory` (created). Throws std::runtime_error that
/// names the file.
void write_over_link(const std::filesystem::path& directory, const std::vector<OverLinkRow>& rows);

}  // namespace feltwire
