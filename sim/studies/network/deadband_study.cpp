#include "sim/studies/network/deadband_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/parallel.hpp"

namespace feltwire {
namespace {

constexpr double kDeadbandStiffness = 1000.0;  // [N/m] stiffness of all surfaces
constexpr double kDeadbandBall = 0.04;         // [m] radius of the ball
constexpr double kTremor = 1e-4;               // [m] tremor of the hand, RMS per axis

Scene surface(const char* name, const Shape& shape, double friction) {
  Object object;
  object.name = name;
  object.shape = shape;
  object.material = {.stiffness = kDeadbandStiffness,
                     .static_friction = friction,
                     .dynamic_friction = 0.75 * friction};
  return Scene(name, {object});
}

DeadbandTask task(const char* name, const Scene& scene, HandPath path) {
  DeadbandTask t{.name = name, .scene = scene, .hand = {}, .recording = {}};
  t.hand.spec = builtin_device("simulated");
  t.hand.task.path = path;
  t.hand.task.tremor = kTremor;
  return t;
}

NetworkRunOptions options_of(const DeadbandTask& task, const DeadbandGrid& grid,
                             const DeadbandKind& kind, double fraction) {
  NetworkRunOptions options;
  options.hand = task.hand;
  options.recording = task.recording;
  options.parameters = grid.parameters;
  options.parameters.predictor = kind.predictor;
  options.parameters.local_model = kind.model;
  if (kind.position) options.parameters.position_deadband = fraction;
  if (kind.force) options.parameters.force_deadband = fraction;
  options.link = grid.link;
  options.duration = task.duration;
  return options;
}

/// Returns the positions of a run as a recording, which another run can replay.
Recording recorded(const NetworkRunResult& run) {
  Recording recording;
  for (const NetworkSample& s : run.samples)
    recording.poses.push_back({s.time, {.position = s.position}});
  return recording;
}

double saved(const DatagramCount& now, const DatagramCount& before) {
  return 1.0 - static_cast<double>(now.datagrams) / static_cast<double>(before.datagrams);
}

void compare_forces(const NetworkRunResult& run, const NetworkRunResult& all, DeadbandRow& row) {
  double error = 0.0, force = 0.0;
  std::size_t ticks = 0;
  const std::size_t count = std::min(run.samples.size(), all.samples.size());
  for (std::size_t n = 0; n < count; ++n) {
    const Vec3 is = run.samples[n].held.force(), was = all.samples[n].held.force();
    if (is.isZero(0.0) && was.isZero(0.0)) continue;
    const double off = (is - was).norm();
    error += off * off;
    force += was.squaredNorm();
    row.error_max = std::max(row.error_max, off);
    ++ticks;
  }
  if (ticks == 0 || !(force > 0.0)) return;
  constexpr double kDecibels = 10.0;
  row.error_rms = std::sqrt(error / static_cast<double>(ticks));
  row.relative = std::sqrt(error / force);
  row.snr =
      error > 0.0 ? kDecibels * std::log10(force / error) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<DeadbandTask> deadband_tasks(const std::optional<Recording>& recording) {
  std::vector<DeadbandTask> tasks;
  tasks.push_back(task("wall press", surface("wall", Plane{}, 0.0), HandPath::press));

  DeadbandTask glide =
      task("sphere glide", surface("ball", Sphere{kDeadbandBall}, 0.0), HandPath::orbit);
  glide.hand.task.radius = kDeadbandBall - glide.hand.task.depth;
  glide.hand.task.depth = 0.0;
  tasks.push_back(glide);

  DeadbandTask taps = task("taps", surface("wall", Plane{}, 0.0), HandPath::taps);
  taps.hand.task.frequency = 1.5;
  tasks.push_back(taps);

  tasks.push_back(task("friction", surface("wall", Plane{}, 0.5), HandPath::figure_eight));
  if (recording && !recording->poses.empty()) {
    DeadbandTask replay = task("recording", surface("plane", Plane{}, 0.3), HandPath::press);
    replay.recording = recording;
    replay.duration = recording->poses.back().time - recording->poses.front().time;
    tasks.push_back(replay);
  }
  return tasks;
}

std::vector<DeadbandRow> run_deadband(const std::vector<DeadbandTask>& tasks,
                                      const DeadbandGrid& grid) {
  constexpr std::size_t kKinds = std::size(kDeadbandKinds);
  const std::size_t per_task = kKinds * grid.fractions.size();
  // The reference runs have no deadband, so they send every datagram. They replay each movement
  // twice: without and with a local model. All other runs are compared with them.
  constexpr DeadbandKind kEvery[] = {{"every", false, false, Predictor::level, false},
                                     {"every", false, false, Predictor::level, true}};
  std::vector<DeadbandTask> replays = tasks;
  std::vector<std::array<std::optional<NetworkRunResult>, 2>> every(tasks.size());
  parallel_for(tasks.size(), [&](std::size_t i) {
    if (!tasks[i].recording)
      replays[i].recording =
          recorded(run_network(tasks[i].scene, options_of(tasks[i], grid, kEvery[0], 0.0)));
    for (std::size_t model = 0; model < every[i].size(); ++model)
      every[i][model] =
          run_network(replays[i].scene, options_of(replays[i], grid, kEvery[model], 0.0));
  });

  std::vector<DeadbandRow> rows(tasks.size() * per_task);
  parallel_for(rows.size(), [&](std::size_t i) {
    const std::size_t t = i / per_task;
    DeadbandRow& row = rows[i];
    row.task = tasks[t].name;
    row.kind = &kDeadbandKinds[i % per_task / grid.fractions.size()];
    row.fraction = grid.fractions[i % grid.fractions.size()];
    const NetworkRunResult& all = *every[t][row.kind->model ? 1 : 0];
    const NetworkRunResult replay =
        run_network(replays[t].scene, options_of(replays[t], grid, *row.kind, row.fraction));
    row.saved_up = saved(replay.up, all.up);
    row.saved_down = saved(replay.down, all.down);
    row.saved = 0.5 * (row.saved_up + row.saved_down);
    row.up_kbit = replay.up.kbit_per_second(tasks[t].duration);
    row.down_kbit = replay.down.kbit_per_second(tasks[t].duration);
    compare_forces(replay, all, row);

    const PortEnergy port =
        tasks[t].recording
            ? replay.measured_port
            : run_network(tasks[t].scene, options_of(tasks[t], grid, *row.kind, row.fraction))
                  .measured_port;
    row.least_margin = port.least_margin();
    row.violations = port.violations();
  });
  return rows;
}

}  // namespace feltwire
