#include "sim/studies/bound/frontier_setup.hpp"

#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "core/bounding/device_account.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene_file/load_scene.hpp"
#include "scenes/bunny_text.hpp"
#include "scenes/paper_sphere_text.hpp"
#include "scenes/paper_wall_text.hpp"
#include "sim/measure/surfaces.hpp"
#include "sim/published_laws/published_laws.hpp"
#include "sim/studies/bound/figures.hpp"

namespace feltwire {
namespace {

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

/// Returns a task on the wall of paper_wall.json, with the stiffness of the case. By the name of
/// the task, the hand slides as in the paper's Figure 2, presses or taps.
CompareTask wall(Object object, const FrontierCase& c) {
  object.material.stiffness = c.wall;
  CompareTask task{c.task, environment(object), [](const Vec3& p) { return p.y(); },
                   figure_setup("wall", kUnbounded, 0.0).hand.task, 4.0};
  task.hand.lead_in = 0.5;
  task.hand.depth = kFrontierPress / c.hand.hand.stiffness + kFrontierPress / c.wall;
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

}  // namespace

TaskSource::TaskSource()
    : paper_wall(parse_scene(embedded::paper_wall, "paper_wall.json").objects().front()),
      paper_sphere(parse_scene(embedded::paper_sphere, "paper_sphere.json").objects().front()),
      mesh(bunny()),
      compared(compare_tasks()) {}

bool on_wall(const std::string& task) {
  return task == "wall" || task == "press" || task == "tap" || task == "tremor";
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
  if (!c.cold) setup.hand.task.air = kFrontierAir;
  setup.duration = (c.duration > 0.0 ? c.duration : task.duration) + setup.hand.task.air;
  setup.law = &law(c.law);
  setup.walls = task.walls;
  setup.bounding.projection = Projection::cone;
  setup.bounding.period = kFrontierPeriod;
  setup.bounding.lag = c.told.time;
  setup.bounding.damping = c.damping;
  setup.bounding.quantum = c.device.quantum;
  setup.bounding.max_force = c.device.max_force;
  setup.delay = delay_samples(c.delay, kFrontierPeriod);
  if (c.need == Need::no_account) return setup;
  setup.account = account_config(spec, kFrontierPeriod);
  setup.account->cap *= c.cap / kAccountCap;
  setup.account->learns_outside_force = c.learns;
  return setup;
}

}  // namespace feltwire
