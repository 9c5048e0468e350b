#include "sim/studies/teleop/tasks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/teleop/bench_energy.hpp"
#include "sim/studies/teleop/lost_contact.hpp"
#include "sim/studies/teleop/minimum_jerk.hpp"

namespace feltwire::teleop {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kAir = -0.02;  // [m] start position, in front of the wall
constexpr double kDeep = 0.03, kHeld = 0.025, kLight = 0.003;  // [m] intended depths of the hand
constexpr double kStroke = 0.05, kSlow = 0.5;  // [m], [Hz] amplitude and frequency of free motion
constexpr double kBegin = 0.5, kArrive = 1.0;  // [s] start and end of the approach

double go_in(double depth, double t) { return minimum_jerk(kAir, depth, kBegin, kArrive, t); }

BenchSetup setup(double duration, const Surroundings& around, const Intention& intention) {
  BenchSetup s;
  s.duration = duration;
  s.around = around;
  s.intention = intention;
  return s;
}

std::vector<Task> make_tasks() {
  using Judge = Task::Judge;
  const Surroundings wall, nothing{.kind = Surroundings::Kind::nothing};
  Surroundings moving = wall, vanishing = wall, weight = wall;
  moving.swing = 5e-3;
  moving.moves_from = 3.0;
  vanishing.vanishes = 4.0;
  weight.kind = Surroundings::Kind::weight;
  const Intention press = [](double t) {
    constexpr double kLeave = 4.5, kAway = 5.0, kAgain = 6.0, kThere = 6.5;  // [s]
    if (t < kLeave) return go_in(kDeep, t);
    return t < kAgain ? minimum_jerk(kDeep, kAir, kLeave, kAway, t)
                      : minimum_jerk(kAir, kDeep, kAgain, kThere, t);
  };
  const Intention sine = [](double t) { return -0.1 + kStroke * std::sin(kTurn * kSlow * t); };
  const Intention taps = [](double t) { return 0.0025 - 0.0125 * std::cos(kTurn * t); };
  const Intention hold = [](double t) { return go_in(kHeld, t); };
  const Intention lean = [](double t) { return go_in(kLight, t); };
  const Intention carry = [](double t) {
    constexpr double kHigh = 0.04, kUp = 1.5, kDown = 4.0, kGround = 5.0;  // [m], [s]
    return t < kDown ? minimum_jerk(kAir, kHigh, kBegin, kUp, t)
                     : minimum_jerk(kHigh, kAir, kDown, kGround, t);
  };
  const Intention rest_at_last = [sine](double t) { return sine(std::min(t, 60.0)); };
  std::vector<Task> all{{"free", Judge::free, setup(8.0, nothing, sine), {2.0, 8.0}},
                        {"press_first", Judge::press, setup(4.5, wall, press), {3.0, 4.4}},
                        {"press_second", Judge::press, setup(10.0, wall, press), {8.5, 9.9}},
                        {"taps", Judge::force, setup(8.0, wall, taps), {2.0, 8.0}},
                        {"moving_wall", Judge::force, setup(12.0, moving, hold), {4.0, 12.0}},
                        {"leaving_wall", Judge::force, setup(12.0, moving, lean), {4.0, 12.0}},
                        {"vanishing_wall", Judge::force, setup(8.0, vanishing, hold), {4.5, 8.0}},
                        {"lift", Judge::force, setup(8.0, weight, carry), {2.0, 4.0}},
                        {"blackout", Judge::press, setup(6.0, wall, press), {3.0, 4.4}},
                        {"drift", Judge::drift, setup(63.0, nothing, rest_at_last), {62.5, 63.0}}};
  for (Task& task : all)
    if (task.name == "blackout") {
      task.setup.cut_from = 0.6;
      task.setup.cut_until = 1.0;
      task.setup.duration = 4.5;
    }
  return all;
}

/// Returns the ideal force [N] on the hand. Without delay, the controller of the robot and the
/// surface would act as two springs in series.
double wanted_force(const Task& task, const BenchSample& s, double time) {
  const Surroundings& around = task.setup.around;
  if (around.kind == Surroundings::Kind::nothing || time >= around.vanishes) return 0.0;
  // The hand lifts the weight slowly, so the ideal force is the weight.
  if (around.kind == Surroundings::Kind::weight) return around.mass * kGravity;
  return series_stiffness(task.setup.plant, around.stiffness) *
         std::max(0.0, s.hand - s.offset - s.surface);
}

double energy_made(const BenchSetup& setup, const std::vector<BenchSample>& samples) {
  const Plant& plant = setup.plant;
  HandEnergy hand;
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const double way = samples[n].shown - samples[n - 1].shown;
    hand.add(-samples[n].held * way, plant.leader_damping * way * way / plant.period,
             samples[n].pushed);
  }
  return hand.made();
}

double root_mean(double squares, double count) { return std::sqrt(squares / std::max(1.0, count)); }

}  // namespace

const std::vector<Task>& tasks() {
  static const std::vector<Task> all = make_tasks();
  return all;
}

double series_stiffness(const Plant& plant, double surface) {
  return plant.stiffness * surface / (plant.stiffness + surface);
}

Measured judge(const Task& task, const std::vector<BenchSample>& samples, double round_trip) {
  const double period = task.setup.plant.period;
  const double series = series_stiffness(task.setup.plant, task.setup.around.stiffness);
  const auto at = [&](double time) {
    return static_cast<std::size_t>(std::llround(time / period));
  };
  const std::size_t first = at(task.window.from);
  const std::size_t last = std::min(at(task.window.until), samples.size() - 1);
  const std::size_t late = at(0.5 * round_trip);
  double force = 0.0, depth = 0.0, errors = 0.0, wanted = 0.0, forces = 0.0, behind = 0.0;
  std::vector<double> hand;
  for (std::size_t n = first; n < last; ++n) {
    const BenchSample& s = samples[n];
    const double held = samples[n + 1].held;
    const double ideal = wanted_force(task, s, static_cast<double>(n) * period);
    force += held;
    forces += held * held;
    depth += s.hand - s.offset - s.surface;
    errors += (held - ideal) * (held - ideal);
    wanted += ideal * ideal;
    const BenchSample& then = samples[n - std::min(n, late)];
    const double tracking = s.robot - (then.hand - then.offset);
    behind += tracking * tracking;
    hand.push_back(s.hand);
  }
  const auto count = static_cast<double>(hand.size());
  Measured m;
  m.energy_made = energy_made(task.setup, samples);
  for (const BenchSample& s : samples) m.peak_force = std::max(m.peak_force, s.contact);
  constexpr double kShallow = 5e-4;  // [m] no stiffness is computed for a smaller mean depth
  switch (task.judge) {
    case Task::Judge::press:
      if (depth > kShallow * count) m.displayed = force / depth / series;
      m.oscillation = highpass_rms(hand, 1.0 / period);
      m.force_error = root_mean(errors, count);
      break;
    case Task::Judge::force:
      m.force_error = root_mean(errors, count);
      if (wanted > 0.0) m.force_share = std::sqrt(errors / wanted);
      if (task.setup.around.swing > 0.0)
        if (const auto lost = lost_contact(samples, first, last, late, period)) {
          m.phantom = lost->felt;
          m.release = lost->release;
        }
      break;
    case Task::Judge::free:
      m.drag = root_mean(forces, count);
      m.tracking = root_mean(behind, count);
      break;
    case Task::Judge::drift:
      m.drift = root_mean(behind, count);
      break;
  }
  return m;
}

}  // namespace feltwire::teleop
