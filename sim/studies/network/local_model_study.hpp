#pragma once
// A local contact model against forces alone, over round trips and servo rates: the error of the
// hand's force against the scene's force at its true position.

#include <filesystem>
#include <string>
#include <vector>

#include "sim/measure/network_run.hpp"

namespace feltwire {

struct LocalModelGrid {
  std::vector<double> round_trips = {0.0, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2};  // [s]
  std::vector<double> rates = {1e3, 4e3, 1e4};  // [Hz] of the servo, the sphere at kUsualRoundTrip
};
inline constexpr double kUsualRoundTrip = 0.05;  // [s]
inline constexpr double kThinRate = 200.0;       // [datagrams/s] of the rows over the servo rate

struct LocalModelCell {
  std::string task;
  double round_trip = 0.0, rate = 0.0;  // [s], [Hz]
  double datagrams = 0.0;               // [1/s] sent up
  bool modelled = false;
  double felt = 0.0;             // [N] RMS of the scene's force at the true position and velocity
  double error = 0.0;            // [N] RMS of the held force less that
  double direction_error = 0.0;  // [rad] mean angle between the two, if there are both
  double displayed = 0.0;        // [N/m] press: slope of force over true depth, going in; else 0
  double onset = 0.0;            // [s] from the first true contact to the first force
  double oscillation = 0.0;      // [m] RMS of the true position, along its fastest axis,
                                 // faster than a moving average of 51 ms, second half
  double from_model = 0.0;       // share of the ticks that used the model alone
  double patches = 0.0;          // mean of a model
  double kbit_up = 0.0, kbit_down = 0.0;  // [kbit/s] with 28 bytes of headers
  std::uint64_t violations = 0;           // at the port, as the encoders measured
};

/// Every task (press and taps on a wall, round a ball, the same as a mesh, rolled on by a ball,
/// with two textures and as a grid, sliding with friction, over a box's edge, the same as a mesh
/// with a ball, in a room's corner, over the things of the room) at every round trip, with and
/// without a local model; then the ball at every servo rate: without delay and a datagram a tick,
/// and at kUsualRoundTrip with kThinRate datagrams a second. Deterministic.
std::vector<LocalModelCell> run_local_model(const LocalModelGrid& grid = {});

/// Writes local_model.csv, local_model.json and local_model.png, the same bytes every time.
/// `directory` is created. Throws std::runtime_error if something cannot be written or drawn.
void write_local_model(const std::filesystem::path& directory,
                       const std::vector<LocalModelCell>& cells);

/// The cells as a table for people.
std::string local_model_table(const std::vector<LocalModelCell>& cells);

}  // namespace feltwire
