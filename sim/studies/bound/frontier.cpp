#include "sim/studies/bound/frontier.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/measure/fidelity.hpp"
#include "sim/measure/network_run.hpp"
#include "sim/published_laws/published_laws.hpp"
#include "sim/studies/bound/frontier_setup.hpp"

namespace feltwire {
namespace {

constexpr double kPeriod = kFrontierPeriod;
constexpr double kAir = kFrontierAir;

/// Returns the largest excess [J] of the energy delivered to the hand over the dissipated energy.
/// The energy that damping dissipates is computed from the encoder's positions. Friction is
/// computed from the motor's true positions, and counts only if the energy account also counts it.
double energy_made(const FrontierCase& c, const std::vector<ExperimentSample>& samples) {
  double left = 0.0, least = 0.0;
  Vec3 before = samples.front().motor;
  for (const ExperimentSample& s : samples) {
    left += c.damping * s.displacement.squaredNorm() / kPeriod - s.held.dot(s.displacement);
    if (c.need == Need::inertia_friction)
      left += c.device.friction * (s.motor - before).lpNorm<1>();
    before = s.motor;
    least = std::min(least, left);
  }
  return -least;
}

Object object_of(const FrontierCase& c, const TaskSource& source) {
  if (c.task == "bunny") return source.mesh;
  if (c.task == "sphere") return source.paper_sphere;
  if (!on_wall(c.task))
    throw std::invalid_argument("the frontier has no session with the task '" + c.task + "'");
  Object object = source.paper_wall;
  object.material.stiffness = c.wall;
  return object;
}

/// Runs a case as a whole session: with datagrams, an emulated link, a server and a local model.
FrontierRow run_session(const FrontierCase& c, const CompareTask& task, const Object& object) {
  const ExperimentSetup setup = setup_of(c, task);
  NetworkRunOptions options;
  options.hand = setup.hand;
  options.parameters.mode = c.law;
  options.parameters.servo_period = kPeriod;
  options.parameters.local_model = true;
  options.link.up.delay = options.link.down.delay = 0.5 * c.delay;
  options.duration = setup.duration;
  const NetworkRunResult run = run_network(Scene(c.task, {object}), options);
  FrontierRow row{.made = c,
                  .energy_made = std::max(0.0, -run.least_device_margin),
                  .energy = run.true_energy,
                  .excess = run.observed_port.violations()};
  const auto second_half = std::span(run.samples).subspan(run.samples.size() / 2);
  row.direction_error = fidelity(second_half).direction.mean;
  double rendered = 0.0, whole = 0.0;
  for (const NetworkSample& s : second_half) {
    rendered += s.held.elastic.dot(s.ideal.elastic);
    whole += s.ideal.elastic.squaredNorm();
  }
  row.displayed = whole > 0.0 ? rendered / whole : 0.0;
  std::vector<double> distance;
  for (const NetworkSample& s : run.samples) distance.push_back(task.distance(s.position));
  if (c.task != "tap") row.oscillation = highpass_rms(distance, 1.0 / kPeriod);
  return row;
}

FrontierRow run_case(const FrontierCase& c, const TaskSource& source) {
  const CompareTask task = task_of(c, source);
  if (c.session) return run_session(c, task, object_of(c, source));
  const ExperimentSetup setup = setup_of(c, task);
  const auto samples = run_experiment(task.touch, setup);
  FrontierRow row{
      .made = c, .energy_made = energy_made(c, samples), .energy = samples.back().energy};
  row.direction_error = measure(samples, {}, setup.bounding.damping, kPeriod).direction_error.mean;
  const Environment own = task.touch, own_at_motor = task.touch;
  double rendered = 0.0, whole = 0.0, rendered_at_motor = 0.0, whole_at_motor = 0.0;
  std::vector<double> distance;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const ExperimentSample& s = samples[n];
    distance.push_back(task.distance(s.position));
    row.excess += s.in_debt ? 1 : 0;
    const Vec3 e = own(Tool{s.position, Vec3::Zero()}).elastic;
    if (2 * n < samples.size()) continue;
    rendered += s.rendered.elastic.dot(e);
    whole += e.squaredNorm();
    const Vec3 at_motor = own_at_motor(Tool{s.motor, Vec3::Zero()}).elastic;
    rendered_at_motor += s.rendered.elastic.dot(at_motor);
    whole_at_motor += at_motor.squaredNorm();
  }
  row.displayed = whole > 0.0 ? rendered / whole : 0.0;
  row.displayed_at_encoder = whole_at_motor > 0.0 ? rendered_at_motor / whole_at_motor : 0.0;
  // The intended movement of a tapping hand is fast, so its oscillation is not measured.
  if (c.task != "tap") row.oscillation = highpass_rms(distance, 1.0 / kPeriod);
  return row;
}

/// Measures the effect of a wrong force while the energy account is full. The hand rests in the
/// air, then the force pushes the hand in the direction of its velocity.
void push_on(const FrontierCase& c, const TaskSource& source, CapRow& row) {
  constexpr double kRest = 1.0, kPush = 1.0;  // [s] time without force, time with force
  ExperimentSetup setup = setup_of(c, task_of(c, source));
  setup.hand.task.path = HandPath::press;
  setup.hand.task.depth = -setup.hand.task.clearance;
  setup.duration = kAir + kRest + kPush;
  constexpr auto begin = static_cast<std::size_t>((kAir + kRest) / kPeriod);
  const auto samples = run_experiment(
      [n = std::size_t{0}, f = c.device.max_force](const Tool& tool) mutable {
        Command wrong;
        if (n++ >= begin)
          wrong.elastic = f * (tool.velocity.isZero(0.0) ? Vec3(Vec3::UnitY())
                                                         : Vec3(tool.velocity.normalized()));
        return wrong;
      },
      setup);
  double given = 0.0;
  for (std::size_t n = begin; n < samples.size(); ++n) {
    const ExperimentSample& s = samples[n];
    given += s.held.dot(s.displacement) - c.damping * s.displacement.squaredNorm() / kPeriod;
    row.given = std::max(row.given, given);
    row.speed = std::max(row.speed, (s.position - samples[n - 1].position).norm() / kPeriod);
  }
}

}  // namespace

std::vector<CapRow> cap_trade() {
  constexpr std::array kCaps = {0.5, 1.0, 3.0, 10.0, 30.0};
  const TaskSource source;
  std::vector<CapRow> rows(kCaps.size());
  parallel_for(kCaps.size(), [&](std::size_t i) {
    FrontierCase c{
        .law = "midpoint", .need = Need::inertia_friction, .cold = false, .cap = kCaps[i]};
    rows[i].cap = c.cap;
    rows[i].energy = setup_of(c, task_of(c, source)).account->cap;
    push_on(c, source, rows[i]);
    rows[i].wall = run_case(c, source).displayed;
    c.task = "tap";
    rows[i].taps = run_case(c, source).displayed;
  });
  return rows;
}

std::vector<FrontierRow> run_frontier(const std::vector<FrontierCase>& cases) {
  const TaskSource source;
  std::vector<FrontierRow> rows(cases.size());
  parallel_for(cases.size(), [&](std::size_t i) { rows[i] = run_case(cases[i], source); });
  return rows;
}

}  // namespace feltwire
