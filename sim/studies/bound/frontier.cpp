#include "sim/studies/bound/frontier.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "core/bounding/device_account.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene_file/load_scene.hpp"
#include "scenes/bunny_text.hpp"
#include "scenes/paper_sphere_text.hpp"
#include "scenes/paper_wall_text.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/measure/fidelity.hpp"
#include "sim/measure/network_run.hpp"
#include "sim/measure/surfaces.hpp"
#include "sim/published_laws/published_laws.hpp"
#include "sim/studies/bound/figures.hpp"

namespace feltwire {
namespace {

constexpr double kPeriod = 1e-3;         // [s] servo period
constexpr double kPress = 3.0;           // [N] force with which the hand presses
constexpr double kAir = 2.0;             // [s] free motion before contact, if the case is not cold
constexpr double kFrictionShare = 0.75;  // ratio of assumed to true dry friction

/// Returns the bunny of scenes/bunny.json.
Object bunny() {
  constexpr double kCentimetre = 0.01;  // [m] length unit of the file
  Object object;
  object.name = "bunny";
  object.shape = Mesh{std::make_shared<MeshSurface>(
      TriangleMesh(parse_mesh(embedded::bunny, "bunny.obj", kCentimetre)),
      MeshOptions{.smooth = true})};
  object.pose.orientation = Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  object.material = {.stiffness = 800.0, .static_friction = 0.4, .dynamic_friction = 0.3};
  return object;
}

/// Returns the task `bunny`: the hand slides to and fro over the bunny's back, and presses with
/// 3 N.
CompareTask over_bunny(const Object& bunny) {
  HandTask hand;
  hand.path = HandPath::slide;
  hand.center = Vec3(0.01, -0.01, 0.0626);
  return {"bunny", environment(bunny),
          [&bunny](const Vec3& p) {
            const MeshSurface& surface = *std::get<Mesh>(bunny.shape).surface;
            const Vec3 q = bunny.pose.orientation.conjugate() * (p - bunny.pose.position) -
                           surface.mesh().origin();
            const auto nearest = surface.nearest(q, std::numeric_limits<double>::infinity());
            return surface.side_of(q, nearest) < 0.0 ? -nearest.distance : nearest.distance;
          },
          hand, 8.0};
}

/// The objects and tasks of all cases. They are made only once, because it is slow to parse a
/// scene.
struct TaskSource {
  Object paper_wall = parse_scene(embedded::paper_wall, "paper_wall.json").objects().front();
  Object paper_sphere = parse_scene(embedded::paper_sphere, "paper_sphere.json").objects().front();
  Object mesh = bunny();
  std::vector<CompareTask> compared = compare_tasks();
};

/// Returns a task on the wall of paper_wall.json, with the stiffness of the case. By the name of
/// the task, the hand slides as in the paper's Figure 2, presses or taps.
CompareTask wall(Object object, const FrontierCase& c) {
  object.material.stiffness = c.wall;
  CompareTask task{c.task, environment(object), [](const Vec3& p) { return p.y(); },
                   figure_setup("wall", kUnbounded, 0.0).hand.task, 4.0};
  task.hand.lead_in = 0.5;
  task.hand.depth = kPress / c.hand.hand.stiffness + kPress / c.wall;
  if (c.task == "tap") {
    task.hand.path = HandPath::taps;
    task.hand.frequency = 2.0;
  }
  if (c.task == "press" || c.task == "tremor") task.hand.path = HandPath::press;
  if (c.task == "tremor") {
    task.hand.tremor = 1e-4;
    task.duration = 30.0;
  }
  return task;
}

CompareTask task_of(const FrontierCase& c, const TaskSource& source) {
  if (on_wall(c.task)) return wall(source.paper_wall, c);
  if (c.task == "bunny") return over_bunny(source.mesh);
  for (const CompareTask& task : source.compared)
    if (task.name == c.task) return task;
  throw std::invalid_argument("the frontier has no task '" + c.task + "'");
}

ExperimentSetup setup_of(const FrontierCase& c, const CompareTask& task) {
  ExperimentSetup setup;
  DeviceSpec& spec = setup.hand.spec;
  spec = builtin_device("simulated");
  spec.damping = c.damping;
  spec.apparent_mass = c.device.mass;
  spec.coulomb_friction = c.device.friction;
  const bool friction = c.need == Need::inertia_friction;
  spec.least_mass = friction || c.need == Need::inertia ? c.device.mass : 0.0;
  spec.least_friction = friction ? kFrictionShare * c.device.friction : 0.0;
  spec.hand_force = c.hand_force;
  spec.position_resolution = c.device.quantum;
  spec.max_force = spec.continuous_force = c.device.max_force;
  spec.actuation.lag = c.told.time;
  spec.actuation.kind = c.told.kind;
  setup.hand.hand = c.hand.hand;
  if (c.plant) setup.hand.plant = *c.plant;
  setup.hand.task = task.hand;
  if (!c.cold) setup.hand.task.air = kAir;
  setup.duration = (c.duration > 0.0 ? c.duration : task.duration) + setup.hand.task.air;
  setup.law = &law(c.law);
  setup.walls = task.walls;
  setup.bounding.projection = Projection::cone;
  setup.bounding.period = kPeriod;
  setup.bounding.lag = c.told.time;
  setup.bounding.damping = c.damping;
  setup.bounding.quantum = c.device.quantum;
  setup.bounding.max_force = c.device.max_force;
  setup.delay = delay_samples(c.delay, kPeriod);
  if (c.need == Need::no_account) return setup;
  setup.account = account_config(spec, kPeriod);
  setup.account->cap *= c.cap / kAccountCap;
  setup.account->learns_outside_force = c.learns;
  return setup;
}

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

bool on_wall(const std::string& task) {
  return task == "wall" || task == "press" || task == "tap" || task == "tremor";
}

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
