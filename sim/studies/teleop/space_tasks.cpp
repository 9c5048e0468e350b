#include "sim/studies/teleop/space_tasks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/numeric.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/teleop/bench_energy.hpp"
#include "sim/studies/teleop/minimum_jerk.hpp"

namespace feltwire::teleop::in_space {
namespace {

/// [N] Largest norm of the error of the force sensor: sqrt(3) times the largest error of an axis,
/// which is 3.5 times 10 mN.
constexpr double kWrenchNoise = 0.06;

/// Returns the intended position [m] of the hand at the time t [s]. The hand moves from 20 mm above
/// the ball to 30 mm below its surface, then 40 degrees around its center in 4 s.
Vec3 around_ball(double t) {
  constexpr double kBall = 0.1, kAbove = 0.02, kInside = 0.03;  // [m]
  constexpr double kHalfWay = 20.0 / 180.0 * std::numbers::pi;
  const double angle = kHalfWay * (2.0 * std::clamp((t - 4.0) / 4.0, 0.0, 1.0) - 1.0);
  const double radius = kBall + kAbove - (kAbove + kInside) * eased(0.5, 2.5, t);
  return radius * Vec3(std::sin(angle), 0.0, std::cos(angle));
}

/// Returns the intended position [m] of the hand at the time t [s]. The hand moves to a point
/// 1.5 mm beside the axis of the hole, then down to 10 mm below the floor of the hole.
Vec3 into_hole(double t) {
  constexpr double kBeside = 1.5e-3, kOver = 0.02, kDown = 0.07;  // [m]
  const Vec3 home(-0.03, 0.01, kOver), over(kBeside, 0.0, kOver);
  Vec3 place = home + eased(0.5, 1.5, t) * (over - home);
  place.z() -= kDown * eased(2.0, 5.0, t);
  return place;
}

std::vector<SpaceTask> make_tasks() {
  SpaceSetup ball;
  ball.plant.wrench_noise = kWrenchNoise;
  ball.intention = around_ball;
  ball.duration = 8.5;
  SpaceSetup hole = ball;
  hole.around.kind = Shape::Kind::hole;
  hole.intention = into_hole;
  hole.duration = 7.0;
  return {{"sphere", ball, {4.5, 8.0}}, {"peg", hole, {2.5, 6.9}}};
}

double energy_made(const Plant& plant, const std::vector<SpaceSample>& samples) {
  HandEnergy hand;
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const Vec3 way = samples[n].shown - samples[n - 1].shown;
    hand.add(-samples[n].held.dot(way), plant.leader_damping * way.squaredNorm() / plant.period,
             samples[n].pushed);
  }
  return hand.made();
}

/// Returns the RMS [m] of the oscillation, over the three axes together.
double swing(const std::vector<Vec3>& places, double rate) {
  double squares = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> one;
    one.reserve(places.size());
    for (const Vec3& place : places) one.push_back(place[axis]);
    const double rms = highpass_rms(one, rate);
    squares += rms * rms;
  }
  return std::sqrt(squares);
}

}  // namespace

const std::vector<SpaceTask>& space_tasks() {
  static const std::vector<SpaceTask> all = make_tasks();
  return all;
}

Measured judge(const SpaceTask& task, const std::vector<SpaceSample>& samples) {
  const Plant& plant = task.setup.plant;
  const Shape& shape = task.setup.around;
  const double series = series_stiffness(plant, shape.stiffness);
  const auto at = [&](double time) {
    return static_cast<std::size_t>(std::llround(time / plant.period));
  };
  const std::size_t first = at(task.window.from);
  const std::size_t last = std::min(at(task.window.until), samples.size() - 1);
  const bool hole = shape.kind == Shape::Kind::hole;
  SurfaceProxy proxy(shape, samples.front().hand);
  double force = 0.0, depth = 0.0, errors = 0.0, wanted = 0.0;
  std::vector<Vec3> hand;
  for (std::size_t n = 0; n < last; ++n) {
    const SpaceSample& s = samples[n];
    const Vec3 goal = s.hand - s.offset;
    if (!hole) proxy.follow(goal);
    if (n < first) continue;
    const Vec3 held = samples[n + 1].held;
    const Vec3 ideal = hole ? Vec3(-s.contact) : Vec3(-proxy.force(goal, series));
    errors += (held - ideal).squaredNorm();
    wanted += ideal.squaredNorm();
    depth += shape.radius - length(goal);
    force -= held.dot(direction(goal));
    hand.push_back(s.hand);
  }
  const auto count = static_cast<double>(hand.size());
  Measured m;
  m.energy_made = energy_made(plant, samples);
  for (const SpaceSample& s : samples) m.peak_force = std::max(m.peak_force, length(s.contact));
  m.force_error = std::sqrt(errors / count);
  if (wanted > 0.0) m.force_share = std::sqrt(errors / wanted);
  m.oscillation = swing(hand, 1.0 / plant.period);
  constexpr double kShallow = 5e-4;  // [m] no stiffness is computed for a smaller mean depth
  if (hole)
    m.inserted = -samples[last].robot.z();
  else if (depth > kShallow * count)
    m.displayed = force / depth / series;
  return m;
}

}  // namespace feltwire::teleop::in_space
