#include "sim/studies/bound/rate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "client/hands/simulated_device.hpp"
#include "core/base/parallel.hpp"
#include "core/bounding/bounding.hpp"
#include "core/scene/scene.hpp"
#include "sim/hands/amplifier_lag.hpp"
#include "sim/measure/cost.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/bound/in_float.hpp"

namespace feltwire {
namespace {

constexpr double kRatePress = 3.0;  // [N] force with which the hand presses
constexpr double kBall = 0.09;      // [m] radius of the ball
constexpr double kPressDuration = 1.5, kSlideDuration = 6.0;  // [s]

struct Surface {
  std::string name;
  double stiffness;  // [N/m]
  bool ball;
};
const std::array<Surface, 3> kSurfaces = {
    {{"wall 40 kN/m", 4e4, false}, {"wall 1 kN/m", 1e3, false}, {"sphere 5 kN/m", 5e3, true}}};

Scene scene_of(const Surface& surface) {
  Object object{.name = surface.name,
                .shape = Plane{},
                .pose = {},
                .material = {.stiffness = surface.stiffness}};
  if (surface.ball) {
    object.shape = Sphere{kBall};
  } else {
    object.material.viscous_friction = 10.0;  // [N s/m] as in paper_wall.json
  }
  return Scene("rate", {object});
}

/// Returns the height [m] over the surface. The origin is a point of the wall, or the centre of the
/// ball.
double height(const Surface& surface, const Vec3& position) {
  return surface.ball ? position.norm() - kBall : position.z();
}
Vec3 normal(const Surface& surface, const Vec3& position) {
  return surface.ball ? position.normalized() : Vec3::UnitZ();
}

SimulatedHandOptions hand_of(const Surface& surface, const Hand& hand, double damping,
                             const RateGrid& grid, bool slides) {
  SimulatedHandOptions options;
  options.hand = hand;
  options.plant = for_any_hand(grid.plant);
  options.spec = builtin_device("simulated");
  if (grid.told) options.spec.actuation.lag = lag_of(grid.plant.amplifier).time;
  options.spec.damping = damping;
  HandTask& task = options.task;
  task.depth = kRatePress / options.hand.stiffness;
  task.center = surface.ball ? Vec3(0, 0, kBall) : Vec3::Zero();
  task.lead_in = 1.0;
  task.clearance = 1e-3;
  // Hand and surface are springs in series, so the depth includes the surface's compression.
  if (!slides) task.depth += kRatePress / surface.stiffness;
  if (!slides) return options;
  if (surface.ball) {
    task.center = Vec3::Zero();
    go_round(task, kBall);
  } else {
    task.path = HandPath::slide;
    task.radius = 0.03;
  }
  return options;
}

struct RateSample {
  Vec3 position, held;  // [m] true position; [N] force after this sample
  Vec3 acted;           // [N] force before this sample
  Vec3 ideal;           // [N] surface force at the true position and velocity
  BoundingStep told;
  Tool tool;
};

template <class Real>
std::vector<RateSample> run(const Surface& surface, const SimulatedHandOptions& hand, double rate,
                            double origin, double duration) {
  BoundingConfig config;
  config.projection = Projection::cone;
  config.period = 1.0 / rate;
  config.damping = hand.spec.damping;
  config.lag = hand.spec.actuation.lag;
  config.max_force = hand.spec.max_force;
  BasicBounding<Real> bounding = bounding_in<Real>(config);
  const Scene scene = scene_of(surface);
  TouchMemory memory = scene.memory(), ideal_memory = scene.memory();
  SimulatedDevice device(hand);
  const Vec3 to_world = Vec3::Constant(origin);
  // Returns the measured position in the world frame, rounded to the precision of Real.
  const auto read = [&](std::size_t n) -> Vector3<Real> {
    const auto now = Nanoseconds(std::llround(static_cast<double>(n) * config.period * 1e9));
    return (device.read(now).pose.position + to_world).template cast<Real>();
  };

  Vector3<Real> last = read(0);
  Vec3 acted = Vec3::Zero();
  std::vector<RateSample> samples;
  const auto count = static_cast<std::size_t>(std::llround(duration * rate));
  samples.reserve(count);
  for (std::size_t n = 1; n <= count; ++n) {
    const Vector3<Real> measured = read(n);
    RateSample s;
    s.position = device.true_position();
    s.ideal = scene.touch({s.position, device.true_velocity()}, ideal_memory).force();
    BasicBoundingStep<Real> told;
    told.displacement = measured - last;
    told.hold_time = static_cast<Real>(config.period);
    last = measured;
    s.tool = {measured.template cast<double>() - to_world,
              told.displacement.template cast<double>() / config.period};
    told.command = scene.touch(s.tool, memory).template cast<Real>();
    s.told = {told.displacement.template cast<double>(), Vec3::Zero(), config.period,
              told.command.template cast<double>()};
    s.acted = acted;
    const BasicCommand<Real> rendered = bounding.step(told).rendered;
    const Command held = device.write(rendered.template cast<double>());
    bounding.set_held(held.cast<Real>());
    s.held = acted = held.force();
    samples.push_back(s);
  }
  return samples;
}

std::vector<RateSample> run(const RateArithmetic& arithmetic, const Surface& surface,
                            const SimulatedHandOptions& hand, double rate, double duration) {
  return arithmetic.in_float ? run<float>(surface, hand, rate, arithmetic.origin, duration)
                             : run<double>(surface, hand, rate, arithmetic.origin, duration);
}

/// Returns the slope [N/m] of force over depth by least squares, from the first contact to the
/// deepest point.
double pressing_slope(const Surface& surface, const std::vector<RateSample>& samples) {
  double deepest = 0.0, n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const RateSample& s : samples) {
    const double depth = -height(surface, s.position);
    if (depth <= deepest) continue;
    deepest = depth;
    const double force = s.held.dot(normal(surface, s.position));
    n += 1, x += depth, y += force, xx += depth * depth, xy += depth * force;
  }
  const double spread = n * xx - x * x;
  return spread > 0.0 ? (n * xy - x * y) / spread : 0.0;
}

RateCell measure_cell(const Surface& surface, double damping, double rate, const RateGrid& grid,
                      const RateArithmetic& arithmetic, const NamedHand& named) {
  RateCell cell{surface.name, damping, rate, arithmetic.name, named.name, 0.0, 0.0, 0.0};
  const Hand& hand = named.hand;
  cell.displayed = pressing_slope(
      surface,
      run(arithmetic, surface, hand_of(surface, hand, damping, grid, false), rate, kPressDuration));

  const auto samples =
      run(arithmetic, surface, hand_of(surface, hand, damping, grid, true), rate, kSlideDuration);
  std::vector<double> heights, angles;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const RateSample& s = samples[n];
    heights.push_back(height(surface, s.position));
    if (2 * n < samples.size() || s.acted.norm() < 1e-3 || s.ideal.norm() < 1e-3) continue;
    angles.push_back(angle_between(s.acted, s.ideal));
  }
  cell.direction_error = spread(std::move(angles)).mean;
  cell.oscillation = highpass_rms(heights, rate);
  return cell;
}

template <class Real>
double bound_cost_ns(const std::vector<RateSample>& samples, const BoundingConfig& config,
                     Real& sink) {
  std::vector<BasicBoundingStep<Real>> steps;
  steps.reserve(samples.size());
  for (const RateSample& s : samples)
    steps.push_back({s.told.displacement.cast<Real>(), Vector3<Real>::Zero(),
                     static_cast<Real>(s.told.hold_time), s.told.command.cast<Real>()});
  BasicBounding<Real> bounding = bounding_in<Real>(config);
  return cost_ns(steps.size(),
                 [&](std::size_t i) { sink += bounding.step(steps[i]).rendered.elastic.z(); });
}

}  // namespace

RateGrid hands_rate_grid() {
  RateGrid grid;
  grid.hands.assign(kEightHands.begin(), kEightHands.end());
  grid.float_too = false;
  return grid;
}

std::vector<RateCell> run_rate(const RateGrid& grid) {
  const std::size_t arithmetics = grid.float_too ? std::size(kRateArithmetics) : 1;
  std::vector<std::function<RateCell()>> todo;
  for (const Surface& surface : kSurfaces)
    for (const double damping : grid.dampings)
      for (const double rate : grid.rates)
        for (std::size_t a = 0; a < arithmetics; ++a)
          for (const NamedHand& hand : grid.hands)
            todo.push_back([&surface, damping, rate, &grid, a, &hand] {
              return measure_cell(surface, damping, rate, grid, kRateArithmetics[a], hand);
            });
  std::vector<RateCell> cells(todo.size());
  parallel_for(todo.size(), [&](std::size_t i) { cells[i] = todo[i](); });
  return cells;
}

std::vector<RateCost> measure_rate_cost() {
  constexpr double kDamping = 0.5, kRate = 1000.0;
  std::vector<RateCost> costs;
  // Use the results, so that the compiler does not remove the computation.
  volatile double kept = 0.0;
  for (const Surface& surface : kSurfaces) {
    const SimulatedHandOptions hand = hand_of(surface, kEightHands[0].hand, kDamping, {}, true);
    const auto samples = run(kRateArithmetics[0], surface, hand, kRate, kSlideDuration);
    BoundingConfig config;
    config.projection = Projection::cone;
    config.period = 1.0 / kRate;
    config.damping = kDamping;
    config.max_force = hand.spec.max_force;
    const Scene scene = scene_of(surface);
    TouchMemory memory = scene.memory();
    double force = 0.0, sink_double = 0.0;
    float sink_float = 0.0F;
    RateCost cost{surface.name, 0.0, 0.0, 0.0};
    cost.touch_ns = cost_ns(samples.size(), [&](std::size_t i) {
      force += scene.touch(samples[i].tool, memory).elastic.z();
    });
    cost.bound_double_ns = bound_cost_ns<double>(samples, config, sink_double);
    cost.bound_float_ns = bound_cost_ns<float>(samples, config, sink_float);
    kept = force + sink_double + static_cast<double>(sink_float);
    costs.push_back(cost);
  }
  static_cast<void>(kept);
  return costs;
}

}  // namespace feltwire
