#include "core/dynamics/world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/base/numeric.hpp"
#include "core/dynamics/body_tool_contact.hpp"
#include "core/dynamics/diverged_trees.hpp"
#include "core/dynamics/mujoco_buffers.hpp"
#include "core/dynamics/point_tool_contact.hpp"
#include "core/dynamics/state_snapshots.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire {
namespace {

constexpr double kSnapshotInterval = 0.1;  // [s]
constexpr int kFreeCoordinates = 7, kFreeSpeeds = 6;

mujoco::Simulation simulation_of(const Mechanism& mechanism) {
  try {
    return mujoco::Simulation(mechanism.model(), mujoco::kMostMemory, mechanism.start());
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(std::string(error.what()) + "; check the scene");
  }
}

}  // namespace

/// The MuJoCo side: the simulation, and its earlier good states.
struct World::Run {
  explicit Run(const Mechanism& mechanism)
      : simulation(simulation_of(mechanism)),
        parts(mechanism.parts()),
        snapshots(model(), *data()),
        diverged_trees(model()) {}

  /// Whether a warning of the last step says that it failed. MuJoCo has then reset itself.
  bool broken() const noexcept {
    return data()->warning[mjWARN_BADQPOS].number != 0 ||
           data()->warning[mjWARN_BADQVEL].number != 0 ||
           data()->warning[mjWARN_BADQACC].number != 0;
  }
  std::uint64_t take_warnings() noexcept {
    std::uint64_t count = 0;
    for (const int kind : {mjWARN_INERTIA, mjWARN_CONTACTFULL, mjWARN_CNSTRFULL}) {
      count += static_cast<std::uint64_t>(data()->warning[kind].number);
      data()->warning[kind].number = 0;
    }
    return count;
  }
  /// Puts lost bodies back to their start. Returns their number.
  std::uint64_t put_back_lost() noexcept {
    std::uint64_t count = 0;
    for (int j = 0; j < model().njnt; ++j) {
      if (model().jnt_type[j] != mjJNT_FREE) continue;
      const int q = model().jnt_qposadr[j];
      if (!(length(Vec3(mujoco::vector(data()->qpos + q) - mujoco::vector(model().qpos0 + q))) >
            kLost))
        continue;
      std::copy_n(model().qpos0 + q, kFreeCoordinates, data()->qpos + q);
      std::fill_n(data()->qvel + model().jnt_dofadr[j], kFreeSpeeds, 0.0);
      ++count;
    }
    return count;
  }

  /// Marks the bodies that MuJoCo's warnings of the last step name. False if a warning names an
  /// unknown body.
  bool mark_warned() noexcept {
    const auto number = [&](int kind) { return data()->warning[kind].number; };
    const auto index = [&](int kind) { return data()->warning[kind].lastinfo; };
    for (const int kind : {mjWARN_BADQVEL, mjWARN_BADQACC}) {
      if (number(kind) == 0) continue;
      if (index(kind) < 0 || index(kind) >= model().nv) return false;
      diverged_trees.mark(model().dof_bodyid[index(kind)]);
    }
    if (number(mjWARN_BADQPOS) == 0) return true;
    int joint = model().njnt - 1;
    while (joint >= 0 && model().jnt_qposadr[joint] > index(mjWARN_BADQPOS)) --joint;
    if (joint < 0) return false;
    diverged_trees.mark(model().jnt_bodyid[joint]);
    return true;
  }

  const mjModel& model() const { return simulation.model(); }
  mjData* data() const { return simulation.data(); }

  mujoco::Simulation simulation;
  const std::vector<Mechanism::Part>& parts;
  StateSnapshots snapshots;
  DivergedTrees diverged_trees;  // of the last failed step
};

namespace {

/// The share of a force [N] that the hand's limit allows on moving objects.
double allowed(const BodyContactState& contacts, double force) {
  return force > contacts.most_force ? contacts.most_force / force : 1.0;
}

const Mechanism& mechanism_of(const Scene& scene) {
  if (scene.mechanism() == nullptr)
    throw std::invalid_argument("scene '" + scene.name() +
                                "': nothing moves in it; no world needed");
  return *scene.mechanism();
}

}  // namespace

World::World(const Scene& scene)
    : tick_(mechanism_of(scene).model().opt.timestep),
      objects_(scene),
      run_(std::make_unique<Run>(mechanism_of(scene))) {
  look();
}

World::~World() = default;

const mjModel_& World::model() const noexcept { return run_->model(); }

mjData_& World::state() noexcept { return *run_->data(); }

WorldMoment World::moment() const noexcept {
  return {.tick = tick_,
          .steps = counters_.steps,
          .resets = counters_.resets,
          .now = counters_.steps + passed_,
          .trust = trust_,
          .gravity = gravity()};
}

/// Reads poses and velocities from MuJoCo after mj_step1.
void World::look() noexcept {
  for (std::size_t i = 0; i < objects_.moving(); ++i) {
    const Mechanism::Part& part = run_->parts[i];
    const Quaternion turned = mujoco::quaternion(mujoco::entry<4>(run_->data()->xquat, part.body));
    const Vec3 arm = turned * part.in_body.position;
    Pose pose;
    pose.position = mujoco::vector(mujoco::entry<3>(run_->data()->xpos, part.body)) + arm;
    pose.orientation = (turned * part.in_body.orientation).normalized();
    std::array<mjtNum, 6> velocity{};  // of the body's frame, world axes: angular, linear
    mj_objectVelocity(&run_->model(), run_->data(), mjOBJ_XBODY, part.body, velocity.data(), 0);
    const Vec3 angular = mujoco::vector(velocity.data());
    objects_.place(i, pose, {mujoco::vector(velocity.data() + 3) + angular.cross(arm), angular});
  }
  objects_.placed();
}

bool World::sane(std::size_t part) const noexcept {
  // Written so that the comparison rejects NaN.
  if (!(length(objects_.velocity(part).linear) <= kLargestSpeed)) return false;
  if (!(length(objects_.velocity(part).angular) <= kLargestTurn)) return false;
  const Pose& pose = objects_.pose(part);
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

bool World::sane() const noexcept {
  if (run_->broken()) return false;
  for (std::size_t i = 0; i < objects_.moving(); ++i)
    if (!sane(i)) return false;
  return true;
}

bool World::step() noexcept {
  // advance() is the second half of MuJoCo's step; evaluate() is the first half of the next. So the
  // poses between two steps are up to date.
  bool done = run_->simulation.advance();
  std::fill_n(run_->data()->qfrc_applied, run_->model().nv, 0.0);
  if (done) counters_.returned += run_->put_back_lost();
  done = done && run_->simulation.evaluate();
  counters_.warnings += run_->take_warnings();
  ++counters_.steps;
  trust_ = std::min(1.0, trust_ + tick_ / kRecovery);
  if (done) look();
  if (!done || !sane()) {
    find_broken(!done);
    go_back();
    return false;
  }
  run_->diverged_trees.remember(*run_->data());
  const auto interval = static_cast<std::uint64_t>(std::llround(kSnapshotInterval / tick_));
  if (counters_.steps % interval == 0)
    run_->snapshots.keep(run_->model(), *run_->data(), counters_.steps);
  return true;
}

void World::go_back() noexcept {
  const auto age = static_cast<std::uint64_t>(std::llround(kGoodAge / tick_));
  const std::uint64_t before = counters_.steps > age ? counters_.steps - age : 0;
  run_->snapshots.take_before(before).restore(run_->model(), *run_->data());
  if (!run_->simulation.evaluate() || run_->broken()) [[unlikely]] {
    // It was evaluated successfully before.
    run_->snapshots.initial().restore(run_->model(), *run_->data());
    run_->simulation.evaluate();
  }
  look();
  objects_.begin_anew();
  trust_ = 0.0;
  ++counters_.resets;
  reset_before_ = last_reset_;
  last_reset_ = counters_.steps;
}

void World::find_broken(bool gave_up) noexcept {
  DivergedTrees& broken = run_->diverged_trees;
  broken.clear();
  if (gave_up || !run_->mark_warned()) broken.mark_all();
  for (std::size_t i = 0; i < objects_.moving(); ++i)
    if (!sane(i)) broken.mark(run_->parts[i].body);
  broken.spread();
}

double World::blame(const BodyContactState& contacts) const noexcept {
  const auto age = static_cast<std::uint64_t>(std::llround(kBlameAge / tick_));
  double hardest = 0.0;
  for (std::size_t i = 0; i < contacts.peak_pushes.size(); ++i) {
    const PeakPush& peak = contacts.peak_pushes[i];
    const bool lately = peak.step > reset_before_ && peak.step + age >= last_reset_;
    if (lately && run_->diverged_trees.has(run_->parts[i].body))
      hardest = std::max(hardest, peak.force);
  }
  return hardest;
}

Vec3 World::gravity() const { return run_->simulation.gravity(); }

void World::set_gravity(const Vec3& gravity) noexcept { run_->simulation.set_gravity(gravity); }

Vec3 World::momentum() const noexcept {
  Vec3 sum = Vec3::Zero();
  for (int body = 1; body < run_->model().nbody; ++body) {
    std::array<mjtNum, 6> velocity{};  // of the centre of mass
    mj_objectVelocity(&run_->model(), run_->data(), mjOBJ_BODY, body, velocity.data(), 0);
    sum += run_->model().body_mass[body] * mujoco::vector(velocity.data() + 3);
  }
  return sum;
}

BodyContactState World::contact_state(const ToolView& view, const HandLimits& limits) const {
  const auto found = std::ranges::find(objects_.views(), &view, &MovedView::view);
  if (found == objects_.views().end())
    throw std::invalid_argument(
        "tool: is of another scene than this world; ask for a contact state of one of its tools");
  const std::size_t moving = objects_.moving();
  BodyContactState contacts;
  contacts.most_force = limits.force;
  contacts.pace = HandSpeedLimit(limits.speed, tick_, kRecovery);
  contacts.held = static_cast<std::size_t>(found - objects_.views().begin());
  contacts.forces.assign(moving, Vec3::Zero());
  contacts.torques.assign(moving, Vec3::Zero());
  contacts.peak_pushes.resize(moving);
  contacts.near.parts.reserve(moving);
  contacts.nearness.assign(moving, NeighbourState::far);
  if (view.tool().body) contacts.motions.resize(view.objects().size());
  return contacts;
}

Command World::touch(const Tool& tool, TouchMemory& memory,
                     BodyContactState& contacts) const noexcept {
  return feltwire::touch(objects_, moment(), tool, memory, contacts);
}

Command World::touch(const Pose& device, const Vec3& velocity, double elapsed, BodyMemory& memory,
                     BodyContactState& contacts) const noexcept {
  return feltwire::touch(objects_, moment(), device, velocity, elapsed, memory, contacts);
}

void World::apply(std::size_t part, BodyContactState& contacts, const Vec3& at,
                  double share) noexcept {
  const Vec3 force = -share * contacts.forces[part], torque = -share * contacts.torques[part];
  if ((force.isZero(0.0) && torque.isZero(0.0)) || !force.allFinite() || !torque.allFinite())
    return;
  PeakPush& peak = contacts.peak_pushes[part];
  const std::uint64_t next = counters_.steps + 1;  // the step that takes this push
  const auto age = static_cast<std::uint64_t>(std::llround(kBlameAge / tick_));
  const double hard = length(force);
  if (hard >= peak.force || peak.step + age < next) peak = {hard, next};
  mj_applyFT(&run_->model(), run_->data(), force.data(), torque.data(), at.data(),
             run_->parts[part].body, run_->data()->qfrc_applied);
}

void World::push(BodyContactState& contacts, TouchMemory& memory, double share) noexcept {
  if (!hold_still(objects_, moment(), memory, contacts)) return;
  double force = 0.0;  // [N]
  for (const std::uint32_t part : contacts.near.parts) force += length(contacts.forces[part]);
  const double given = share * allowed(contacts, force);
  const NeighbourSearch& reach = objects_.views()[contacts.held].reach;
  for (const std::uint32_t part : contacts.near.parts)
    apply(part, contacts, reach.nearest(part, contacts.tool.position), given);
}

void World::push(BodyContactState& contacts, BodyMemory& memory, double share) noexcept {
  if (!hold_still(objects_, moment(), memory, contacts)) return;
  double force = 0.0;  // [N]
  for (const Vec3& part : contacts.forces) force += length(part);
  const double given = share * allowed(contacts, force);
  for (std::size_t i = 0; i < contacts.forces.size(); ++i)
    apply(i, contacts, contacts.tool.position, given);
}

}  // namespace feltwire
