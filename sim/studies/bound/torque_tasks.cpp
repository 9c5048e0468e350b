#include "sim/studies/bound/torque_tasks.hpp"

#include <utility>

#include "core/scene_file/load_scene.hpp"

namespace feltwire {
namespace {

constexpr double kPressForce = 3.0;        // [N] force with which the hand presses
constexpr double kBodyStiffness = 1500.0;  // [N/m] stiffness of all surfaces
constexpr double kLean = 0.45;             // [rad] intended lean of the wrist
constexpr double kConeStop = 0.2;          // [rad] lean at which the conical stop begins
constexpr double kScrewTurn = 0.8;         // [rad] amplitude of the wrist's turn with the screw
constexpr double kConeFriction = 0.016;    // [N m s/rad]; 10 N s/m at a lever of 40 mm

constexpr const char* kTable = R"({ "name": "table",
  "tool": { "body": { "box": { "size": [0.06, 0.04, 0.02] }, "points": 800,
                      "coupling": { "stiffness": 1000, "max_force": 8 } } },
  "materials": [ { "name": "wood", "stiffness": 1500, "damping": 2, "static_friction": 0.4, "dynamic_friction": 0.3 } ],
  "objects": [ { "name": "table", "plane": {}, "material": "wood" } ] })";

constexpr const char* kRail = R"({ "name": "rail",
  "tool": { "body": { "capsule": { "radius": 0.01, "length": 0.06 }, "points": 800,
                      "coupling": { "stiffness": 1000, "max_force": 8 } } },
  "materials": [ { "name": "steel", "stiffness": 1500, "static_friction": 0.4, "dynamic_friction": 0.3 } ],
  "objects": [ { "name": "rail", "box": { "size": [0.3, 0.04, 0.01] }, "position": [0, -0.02, 0], "material": "steel" } ] })";

constexpr const char* kRing = R"({ "name": "ring",
  "tool": { "body": { "capsule": { "radius": 0.01, "length": 0.06 }, "points": 800,
                      "coupling": { "stiffness": 1000, "max_force": 8 } } },
  "materials": [ { "name": "brass", "stiffness": 1500, "static_friction": 0.2, "dynamic_friction": 0.15 } ],
  "objects": [ { "name": "ring", "torus": { "major_radius": 0.0235, "minor_radius": 0.013 }, "material": "brass" } ] })";

Vec3 turn_of(const Pose& pose) {
  return rotation_between(Quaternion::Identity(), pose.orientation);
}

HandTask stays() {
  HandTask hand;
  hand.depth = hand.clearance = 0.0;
  return hand;
}

Command end_stop(double stiffness, const Pose& pose) {
  const double beyond = turn_of(pose).z() - 0.5 * kScrewTurn;
  return {.torque = Vec3(0.0, 0.0, beyond > 0.0 ? -stiffness * beyond : 0.0)};
}

/// Returns the lean [rad] of the tool: its rotation vector without the z component.
Vec3 lean_of(const Pose& pose) {
  Vec3 lean = turn_of(pose);
  lean.z() = 0.0;
  return lean;
}

Command cone(double stiffness, const Pose& pose) {
  const Vec3 lean = lean_of(pose);
  const double angle = lean.norm();
  if (!(angle > kConeStop)) return {};
  return {.torque = -stiffness * (angle - kConeStop) / angle * lean};
}

/// A conical stop with viscous friction at right angles to the lean. The friction acts only in
/// contact with the stop.
struct RubbedCone {
  double stiffness;
  Vec3 before = Vec3::Zero();  // [rad] lean at the last call

  Command operator()(const Pose& pose, const Vec3&, double elapsed) {
    Command command = cone(stiffness, pose);
    const Vec3 lean = lean_of(pose);
    if (elapsed > 0.0 && !command.torque.isZero(0.0)) {
      const Vec3 out = lean.normalized();
      const Vec3 velocity = (lean - before) / elapsed;
      command.torque -= kConeFriction * (velocity - velocity.dot(out) * out);
    }
    before = lean;
    return command;
  }
};

TorqueTask body(const char* name, const std::shared_ptr<const Scene>& scene, double above,
                HandPath path, const WristTask& wrist) {
  TorqueTask task{.name = name, .touch = pose_environment(*scene), .scene = scene};
  task.hand.path = path;
  task.hand.center = {0.0, 0.0, above};
  task.wrist = wrist;
  task.pressed = true;
  return task;
}

}  // namespace

std::vector<TorqueTask> joint_tasks(double stiffness) {
  std::vector<TorqueTask> tasks(3);
  tasks[0].name = "end_stop";
  tasks[0].touch = [stiffness](const Pose& pose, const Vec3&, double) {
    return end_stop(stiffness, pose);
  };
  tasks[0].wrist = {WristPath::screwdriver, kScrewTurn};
  tasks[1].name = "cone";
  tasks[1].touch = [stiffness](const Pose& pose, const Vec3&, double) {
    return cone(stiffness, pose);
  };
  tasks[2].name = "cone_friction";
  tasks[2].touch = RubbedCone{stiffness};
  tasks[1].wrist = tasks[2].wrist = {WristPath::tilt, kLean};
  for (TorqueTask& task : tasks) task.hand = stays();
  return tasks;
}

std::vector<TorqueTask> body_tasks() {
  const auto made = [](const char* text, const char* file) {
    return std::make_shared<const Scene>(parse_scene(text, file));
  };
  const auto table = made(kTable, "table"), rail = made(kRail, "rail"), ring = made(kRing, "ring");
  // [m] Half the height of the brick, and half the length of the peg.
  constexpr double kHalfBrick = 0.01, kPegReach = 0.03;
  std::vector<TorqueTask> tasks = {
      body("press", table, kHalfBrick, HandPath::press, {}),
      body("screwdriver", table, kHalfBrick, HandPath::press, {WristPath::screwdriver, 0.5}),
      body("rock", table, kHalfBrick, HandPath::press, {WristPath::tilt, 0.2}),
      body("scrape", table, kHalfBrick, HandPath::slide, {WristPath::scrape, 0.3}),
      body("roll", rail, 0.0, HandPath::slide, {WristPath::roll, 1.2}),
      body("peg", ring, kPegReach, HandPath::press, {WristPath::tilt, 0.15})};
  HandTask& roll = tasks[4].hand;
  roll.center = {0.0, 0.01, 0.0};  // [m] the axis of the bar is 10 mm above the edge
  roll.normal = Vec3::UnitY();
  roll.radius = 0.02;
  TorqueTask& peg = tasks[5];
  peg.pressed = false;
  peg.hand.clearance = kPegReach;
  peg.hand.depth = kPegReach;
  peg.hand.lead_in = 1.5;
  return tasks;
}

void press(TorqueTask& task, const Hand& hand) {
  if (task.pressed) task.hand.depth = kPressForce / hand.stiffness + kPressForce / kBodyStiffness;
}

}  // namespace feltwire
