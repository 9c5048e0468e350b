#pragma once
// The savings and the cost of a perceptual deadband: datagrams each way against the force.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/measure/network_run.hpp"

namespace feltwire {

/// The thinned direction, and the reference of a change.
struct DeadbandKind {
  const char* name;
  bool position, force;
  Predictor predictor;
  bool model = false;  // the client renders a local model
};
inline constexpr DeadbandKind kDeadbandKinds[] = {
    {"position level", true, false, Predictor::level},
    {"force level", false, true, Predictor::level},
    {"force linear", false, true, Predictor::linear},
    {"both level", true, true, Predictor::level},
    {"model level", true, true, Predictor::level, true},
    {"model linear", true, true, Predictor::linear, true}};

/// A movement over a surface: a simulated hand, or a recorded one.
struct DeadbandTask {
  std::string name;
  Scene scene;
  SimulatedHandOptions hand;
  std::optional<Recording> recording;
  double duration = 4.0;  // [s]
};

struct DeadbandGrid {
  std::vector<double> fractions = {0.0, 0.025, 0.05, 0.1, 0.2};  // k
  SessionParameters parameters{};  // for every run; the deadbands are added
  TwoWayLinkOptions link{};
};

struct DeadbandRow {
  std::string task;
  const DeadbandKind* kind = nullptr;
  double fraction = 0.0;
  // The movement of k = 0, replayed, so that both force and datagrams belong to the same movement;
  // k = 0 with or without a local model as well.
  double saved_up = 0.0, saved_down = 0.0, saved = 0.0;  // shares of k = 0's datagrams
  double up_kbit = 0.0, down_kbit = 0.0;                 // [kbit/s] with headers
  /// [N] of the force held against that of k = 0 at the same tick. `relative`: RMS of one over RMS
  /// of the other, over ticks with any force; `snr` [dB] is that as a ratio.
  double error_rms = 0.0, error_max = 0.0, relative = 0.0, snr = 0.0;
  // The hand itself, which the force moves; for a recording, the replay.
  double least_margin = 0.0;     // [J] burned less delivered at the port
  std::uint64_t violations = 0;  // samples after which more had been delivered than burned
};

/// Wall press, sphere glide, taps and a slide with friction, on the built-in simulated device and a
/// tremor of 0.1 mm; and the recording, if one is given, over a plane at z = 0.
std::vector<DeadbandTask> deadband_tasks(const std::optional<Recording>& recording = {});

/// Every task, kind and fraction, the last fastest. Deterministic.
std::vector<DeadbandRow> run_deadband(const std::vector<DeadbandTask>& tasks,
                                      const DeadbandGrid& grid);

/// Writes deadband.csv, deadband.json and deadband.png, the same bytes every time. `directory` is
/// created. Throws std::runtime_error if something cannot be written or drawn.
void write_deadband(const std::filesystem::path& directory, const DeadbandGrid& grid,
                    const std::vector<DeadbandRow>& rows);
std::string deadband_table(const std::vector<DeadbandRow>& rows);

}  // namespace feltwire
