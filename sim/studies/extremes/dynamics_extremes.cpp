#include "sim/studies/extremes/dynamics_extremes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/base/numeric.hpp"
#include "core/dynamics/mujoco_compile.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2]

/// The quantities of a small scene.
struct BodyStress {
  double mass = 1.0;           // [kg] of the body, or of the upper one of two
  double other = 1.0;          // [kg] of the lower one, or of the other one
  double size = 0.05;          // [m] side of a box, diameter of a ball
  double tick = 1e-3;          // [s]
  double assumed_scale = 1.0;  // as in ExtremeMatrix
};

Object still_object(const char* name, const Shape& shape, const Vec3& position = Vec3::Zero()) {
  Object object;
  object.name = name;
  object.shape = shape;
  object.pose.position = position;
  return object;
}

Body free_body(const char* name, double mass, const Vec3& position) {
  Body body;
  body.name = name;
  body.mass = mass;
  body.pose.position = position;
  return body;
}

Scene scene_of(std::vector<Object> objects, const std::vector<int>& body_of,
               const std::vector<Body>& bodies, const BodyStress& stress,
               double gravity = kGravity) {
  const auto mechanism =
      compile(objects, body_of, bodies, {.gravity = Vec3(0.0, 0.0, -gravity), .tick = stress.tick});
  Scene scene("extremes", objects);
  scene.set_mechanism(mechanism);
  return scene;
}

/// A warning of the loader that has one of these words.
std::string warning_with(const Scene& scene, std::initializer_list<const char*> words) {
  for (const std::string& warning : scene.warnings())
    for (const char* word : words)
      if (warning.find(word) != std::string::npos) return warning;
  return {};
}

bool is_finite(const Pose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

ExtremeCell body_cell(const char* judged, const char* reference, double allowed) {
  return {.stress = {}, .judged = judged, .reference = reference, .allowed = allowed};
}

/// Semi-implicit Euler: after n ticks a body has fallen g tick^2 n (n + 1) / 2.
ExtremeCell fall(const BodyStress& stress) {
  ExtremeCell cell = body_cell("fall", "way against the closed form, relative", 1e-9);
  const Scene scene = scene_of({still_object("box", Box{Vec3::Constant(0.5 * stress.size)})}, {0},
                               {free_body("box", stress.mass, Vec3::Zero())}, stress);
  World world(scene);
  for (int n = 1; n * stress.tick < 1.0; ++n) {
    world.step();
    const double way = 0.5 * kGravity * stress.tick * stress.tick * n * (n + 1.0);
    const Pose& pose = world.objects()[0].pose;
    cell.judge(is_finite(pose), std::abs(pose.position.z() / (stress.assumed_scale * way) + 1.0));
  }
  cell.holes += world.counters().resets;
  return cell;
}

/// Returns the number of ticks in `duration` [s].
long ticks_in(double duration, double tick) {
  return static_cast<long>(std::ceil(duration / tick));
}

/// [m] A contact or a stop yields to a speed by its time constant over e, and some ticks until it
/// is seen (core/dynamics/thin_contacts.hpp).
double yield_of(double speed, double tick) {
  constexpr double kContactTicks = 5.0, kSeenTicks = 1.0;
  return speed * tick * (kContactTicks / std::numbers::e + kSeenTicks);
}

/// A slide falls by 0.1 m onto the end of its range.
ExtremeCell slide_stop(const BodyStress& stress) {
  ExtremeCell cell =
      body_cell("slide", "way beyond the stop, over that of a critically damped one", 1.0);
  constexpr double kRange = 0.1;  // [m]
  Body sliding = free_body("box", stress.mass, Vec3::Zero());
  sliding.joint = Joint::slide;
  sliding.axis = Vec3::UnitZ();
  sliding.low = -kRange;
  sliding.high = 0.0;
  const Scene scene = scene_of({still_object("box", Box{Vec3::Constant(0.5 * stress.size)})}, {0},
                               {sliding}, stress);
  World world(scene);
  const double most = yield_of(std::sqrt(2.0 * kGravity * kRange), stress.tick);
  for (long ticks = ticks_in(1.0, stress.tick); ticks > 0; --ticks) {
    world.step();
    const Pose& pose = world.objects()[0].pose;
    const double beyond = std::max({0.0, -kRange - pose.position.z(), pose.position.z()});
    cell.judge(is_finite(pose), beyond / most);
  }
  cell.holes += world.counters().resets;
  return cell;
}

/// A door falls about a horizontal hinge onto the end of its range, one radian below.
ExtremeCell hinge_stop(const BodyStress& stress) {
  ExtremeCell cell =
      body_cell("hinge", "turn beyond the stop, over that of a critically damped one", 1.0);
  constexpr double kRange = 1.0;  // [rad]
  Body door = free_body("door", stress.mass, Vec3::Zero());
  door.joint = Joint::hinge;
  door.axis = Vec3::UnitY();
  door.low = 0.0;
  door.high = kRange;
  const double size = stress.size;
  const Scene scene = scene_of(
      {still_object("door", Box{0.5 * size * Vec3(1.0, 1.0, 0.1)}, Vec3(0.5 * size, 0.0, 0.0))},
      {0}, {door}, stress);
  World world(scene);
  // The door's energy: m g (size / 2) sin(1) = I w^2 / 2, with I = m size^2 / 3 or more.
  const double speed = std::sqrt(3.0 * kGravity * std::sin(kRange) / size);
  const double most = yield_of(speed, stress.tick);
  const double limit = std::min(World::kLargestTurn, World::kLargestSpeed / size);
  const double time_needed = 20.0 / speed;
  for (long ticks = ticks_in(std::min(1.0, time_needed), stress.tick); ticks > 0; --ticks) {
    world.step();
    const Quaternion& turn = world.objects()[0].pose.orientation;
    const double angle = 2.0 * std::atan2(turn.y(), turn.w());
    cell.judge(is_finite(world.objects()[0].pose), std::max({0.0, angle - kRange, -angle}) / most);
  }
  // A door that would turn faster than a world allows is put back, and the loader cannot know it.
  if (speed < limit) cell.holes += world.counters().resets;
  return cell;
}

/// [m] The way by which a body yields that begins on another one: it falls for a tick, and its
/// contact is soft.
double yield_at_rest(double tick) {
  constexpr double kSoftest = 0.01, kContactTicks = 5.0;  // 1 - d of the impedance; its time
  const double contact = kContactTicks * tick;
  return yield_of(kGravity * tick, tick) + kGravity * (tick * tick + kSoftest * contact * contact);
}

/// A box stands on a floor.
ExtremeCell rest(const BodyStress& stress) {
  ExtremeCell cell = body_cell("rest", "way into the floor, over that of the contact law", 1.0);
  const double half = 0.5 * stress.size;
  const Vec3 place(0.0, 0.0, half);
  const Scene scene = scene_of(
      {still_object("floor", Plane{}), still_object("box", Box{Vec3::Constant(half)}, place)},
      {-1, 0}, {free_body("box", stress.mass, place)}, stress);
  World world(scene);
  for (long ticks = ticks_in(1.0, stress.tick); ticks > 0; --ticks) {
    world.step();
    const Pose& pose = world.objects()[1].pose;
    cell.judge(is_finite(pose),
               std::max(0.0, half - pose.position.z()) / yield_at_rest(stress.tick));
  }
  cell.holes += world.counters().resets + world.counters().warnings;
  return cell;
}

/// A box stands on another one, which stands on a floor.
ExtremeCell pile(const BodyStress& stress) {
  ExtremeCell cell =
      body_cell("pile", "way of the upper body into what is below, over the size", 0.25);
  const double half = 0.5 * stress.size;
  const Vec3 low(0.0, 0.0, half), high(0.0, 0.0, 3.0 * half);
  const Scene scene = scene_of(
      {still_object("floor", Plane{}), still_object("lower", Box{Vec3::Constant(half)}, low),
       still_object("upper", Box{Vec3::Constant(half)}, high)},
      {-1, 0, 1}, {free_body("lower", stress.other, low), free_body("upper", stress.mass, high)},
      stress);
  cell.warned = warning_with(scene, {"may sink", "hold each other", "breaks"});
  World world(scene);
  for (long ticks = ticks_in(1.0, stress.tick); ticks > 0; --ticks) {
    world.step();
    const Pose& pose = world.objects()[2].pose;
    cell.judge(is_finite(pose), std::max(0.0, 3.0 * half - pose.position.z()) / stress.size);
  }
  cell.holes += world.counters().resets + world.counters().warnings;
  return cell;
}

/// A hand throws a ball against another one, without gravity: afterwards their momentum stays.
ExtremeCell momentum(const BodyStress& stress) {
  ExtremeCell cell = body_cell("momentum", "momentum against that after the push, relative", 1e-6);
  const double radius = 0.5 * stress.size;
  const Vec3 first = Vec3::Zero(), second(4.0 * radius, 0.0, 0.0);
  std::vector<Object> objects = {still_object("first", Sphere{radius}, first),
                                 still_object("second", Sphere{radius}, second)};
  // A push of 20 ticks, calm at this tick, that gives the ball some 1 m/s at most.
  const double calm = 0.01 * stress.mass / (stress.tick * stress.tick);
  const double slow = stress.mass / (4.0 * stress.tick * radius);
  const double stiffness = std::clamp(std::min(calm, slow), 1e-3, 1e9);
  for (Object& o : objects) o.material.stiffness = stiffness;
  const Scene scene =
      scene_of(std::move(objects), {0, 1},
               {free_body("first", stress.mass, first), free_body("second", stress.other, second)},
               stress, 0.0);
  World world(scene);
  TouchMemory memory = world.view().memory();
  BodyContactState contacts = world.contact_state();
  for (int n = 0; n < 20; ++n) {
    const Vec3 hand(-radius * (1.2 - 0.4 * std::min(1.0, n / 10.0)), 0.0, 0.0);
    const Command felt = world.touch({hand, Vec3::Zero()}, memory, contacts);
    cell.judge(felt.finite(), 0.0);
    world.push(contacts, memory, 1.0);
    world.step();
  }
  world.step();
  const Vec3 pushed = world.momentum();
  if (!(length(pushed) > 0.0)) ++cell.holes;
  const double speed = length(pushed) / stress.mass;
  const double duration = std::min(5.0, 8.0 * radius / speed);
  for (long ticks = ticks_in(duration, stress.tick); ticks > 0; --ticks) {
    world.step();
    cell.judge(is_finite(world.objects()[0].pose) && is_finite(world.objects()[1].pose),
               length(Vec3(world.momentum() - pushed)) / length(pushed));
  }
  cell.holes += world.counters().resets;
  return cell;
}

/// A hand presses a body down with a limit of 10 N.
ExtremeCell hand_limit(const BodyStress& stress) {
  ExtremeCell cell =
      body_cell("hand", "speed that the hand gave, over limit times time over mass", 1.0 + 1e-6);
  constexpr double kLimit = 10.0;  // [N]
  const double radius = 0.5 * stress.size;
  std::vector<Object> objects = {still_object("ball", Sphere{radius})};
  objects[0].material.stiffness = 1e9;
  const Scene scene = scene_of(std::move(objects), {0},
                               {free_body("ball", stress.mass, Vec3::Zero())}, stress, 0.0);
  World world(scene);
  TouchMemory memory = world.view().memory();
  BodyContactState contacts = world.contact_state(world.view(), {.force = kLimit});
  world.touch({Vec3(0.0, 0.0, 2.0 * radius), Vec3::Zero()}, memory, contacts);
  for (int n = 1; n <= 50; ++n) {
    const Command felt =
        world.touch({Vec3(0.0, 0.0, 0.5 * radius), Vec3::Zero()}, memory, contacts);
    const double before = length(world.momentum());
    world.push(contacts, memory, 1.0);
    world.step();
    const double gained = length(world.momentum()) - before;
    cell.judge(felt.finite() && is_finite(world.objects()[0].pose),
               std::max(0.0, gained / (kLimit * stress.tick)));
  }
  return cell;
}

using JudgeBodies = ExtremeCell (*)(const BodyStress&);

void add_body_row(ExtremeMatrix& matrix, const std::string& name, BodyStress stress,
                  std::initializer_list<std::pair<const char*, JudgeBodies>> judges) {
  stress.assumed_scale = matrix.assumed_scale;
  for (const auto& [judged, run] : judges) {
    ExtremeCell cell;
    try {
      cell = run(stress);
    } catch (const std::invalid_argument& error) {
      cell.judged = judged;
      cell.refused = error.what();
    }
    cell.stress = name;
    matrix.cells.push_back(std::move(cell));
  }
}

}  // namespace

ExtremeMatrix run_dynamics_extremes(double assumed_scale) {
  ExtremeMatrix matrix{.part = "dynamics",
                       .title = "worst error against a closed form, relative",
                       .assumed_scale = assumed_scale};
  const std::initializer_list<std::pair<const char*, JudgeBodies>> all = {
      {"fall", fall}, {"slide", slide_stop},  {"hinge", hinge_stop}, {"rest", rest},
      {"pile", pile}, {"momentum", momentum}, {"hand", hand_limit}};
  for (const double mass : {1e-7, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e7})
    add_body_row(matrix, stress_name("mass", mass, "kg"), {.mass = mass, .other = mass}, all);
  for (const double tick : {1e-5, 1e-4, 1e-3, 1e-2, 1e-1})
    add_body_row(matrix, stress_name("tick", tick, "s"), {.tick = tick}, all);
  for (const double size : {1e-9, 1e-6, 1e-3, 1.0, 1e3})
    add_body_row(matrix, stress_name("size", size, "m"), {.size = size}, all);
  for (const double ratio : {1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e9}) {
    const double light = ratio > 1e6 ? 1e-3 : 1.0;  // [kg]
    add_body_row(matrix, stress_name("heavy on light, ratio", ratio, ""),
                 {.mass = light * ratio, .other = light}, {{"pile", pile}, {"momentum", momentum}});
    add_body_row(matrix, stress_name("light on heavy, ratio", ratio, ""),
                 {.mass = light, .other = light * ratio}, {{"pile", pile}, {"momentum", momentum}});
  }
  add_body_row(matrix, "inertia 1e-15 kg m^2", {.mass = 1e-6, .other = 1e-6, .size = 1e-4}, all);
  add_body_row(matrix, "inertia 1e-17 kg m^2", {.mass = 1e-6, .other = 1e-6, .size = 1e-5}, all);
  return matrix;
}

}  // namespace feltwire
