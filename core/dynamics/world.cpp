#include "core/dynamics/world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/base/numeric.hpp"
#include "core/dynamics/diverged_trees.hpp"
#include "core/dynamics/mujoco_buffers.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire {
namespace {

constexpr double kSnapshotInterval = 0.1;  // [s]
constexpr std::size_t kSnapshots = 16;
constexpr int kFreeCoordinates = 7, kFreeSpeeds = 6;

mujoco::Simulation simulation_of(const Mechanism& mechanism) {
  try {
    return mujoco::Simulation(mechanism.model(), mujoco::kMostMemory, mechanism.start());
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(std::string(error.what()) + "; check the scene");
  }
}

}  // namespace

/// The MuJoCo side: the state and a ring of good states.
struct World::Run {
  struct Snapshot {
    std::vector<mjtNum> coordinates, activations;
    std::uint64_t step = 0;
  };

  explicit Run(const Mechanism& mechanism)
      : simulation(simulation_of(mechanism)), parts(mechanism.parts()) {
    initial = snapshot_of(0);
    diverged_trees = DivergedTrees(model());
    ring.assign(kSnapshots, initial);
  }

  Snapshot snapshot_of(std::uint64_t step) const {
    return {
        {data()->qpos, data()->qpos + model().nq}, {data()->act, data()->act + model().na}, step};
  }
  void keep(std::uint64_t step) noexcept {
    newest = (newest + 1) % kSnapshots;
    kept = std::min(kept + 1, kSnapshots);
    Snapshot& place = ring[newest];
    std::copy_n(data()->qpos, model().nq, place.coordinates.begin());
    std::copy_n(data()->act, model().na, place.activations.begin());
    place.step = step;
  }
  /// Removes all states younger than `step`, and the next one. Returns that one.
  const Snapshot& take_before(std::uint64_t step) noexcept {
    while (kept > 0) {
      const Snapshot& last = ring[newest];
      newest = (newest + kSnapshots - 1) % kSnapshots;
      --kept;
      if (last.step <= step) return last;
    }
    return initial;
  }
  void restore(const Snapshot& to) noexcept {
    mj_resetData(&model(), data());
    std::copy(to.coordinates.begin(), to.coordinates.end(), data()->qpos);
    std::copy(to.activations.begin(), to.activations.end(), data()->act);
  }

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
  Snapshot initial;
  std::vector<Snapshot> ring;
  std::size_t newest = 0, kept = 0;
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
    : tick_(mechanism_of(scene).tick()),
      still_(mechanism_of(scene).still()),
      parts_(mechanism_of(scene).parts().size()),
      motions_(parts_),
      followed_(parts_),
      run_(std::make_unique<Run>(mechanism_of(scene))) {
  for (const ToolView& view : scene.views()) {
    const std::span<const Object> moving(view.objects().data() + still_, parts_);
    held_.push_back({&view, view.objects(), NeighbourSearch(moving, view.tool().radius)});
    for (std::size_t i = 0; i < parts_; ++i)
      followed_[i].way |= follows_way(moving[i].shape, moving[i].felt_from);
  }
  look();
}

World::~World() = default;

const mjModel_& World::model() const noexcept { return run_->model(); }

mjData_& World::state() noexcept { return *run_->data(); }

/// Reads poses and velocities from MuJoCo after mj_step1.
void World::look() noexcept {
  for (std::size_t i = 0; i < parts_; ++i) {
    const Mechanism::Part& part = run_->parts[i];
    const Quaternion turned = mujoco::quaternion(mujoco::entry<4>(run_->data()->xquat, part.body));
    const Vec3 arm = turned * part.in_body.position;
    followed_[i].before = objects()[still_ + i].pose;
    Pose pose;
    pose.position = mujoco::vector(mujoco::entry<3>(run_->data()->xpos, part.body)) + arm;
    pose.orientation = (turned * part.in_body.orientation).normalized();
    std::array<mjtNum, 6> velocity{};  // of the body's frame, world axes: angular, linear
    mj_objectVelocity(&run_->model(), run_->data(), mjOBJ_XBODY, part.body, velocity.data(), 0);
    for (MovedView& held : held_) {
      held.objects[still_ + i].pose = pose;
      held.reach.place(i, pose);
    }
    Motion& motion = motions_[i];
    motion.angular = mujoco::vector(velocity.data());
    motion.linear = mujoco::vector(velocity.data() + 3) + motion.angular.cross(arm);
  }
  for (MovedView& held : held_) held.reach.placed();
}

bool World::sane(std::size_t part) const noexcept {
  // Written so that the comparison rejects NaN.
  if (!(length(motions_[part].linear) <= kLargestSpeed)) return false;
  if (!(length(motions_[part].angular) <= kLargestTurn)) return false;
  const Pose& pose = objects()[still_ + part].pose;
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

bool World::sane() const noexcept {
  if (run_->broken()) return false;
  for (std::size_t i = 0; i < parts_; ++i)
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
  if (counters_.steps % interval == 0) run_->keep(counters_.steps);
  return true;
}

void World::go_back() noexcept {
  const auto age = static_cast<std::uint64_t>(std::llround(kGoodAge / tick_));
  const std::uint64_t before = counters_.steps > age ? counters_.steps - age : 0;
  run_->restore(run_->take_before(before));
  if (!run_->simulation.evaluate() || run_->broken()) [[unlikely]] {
    run_->restore(run_->initial);  // it was evaluated successfully before
    run_->simulation.evaluate();
  }
  look();
  for (MovedView& held : held_) held.reach.begin_anew();
  trust_ = 0.0;
  ++counters_.resets;
  reset_before_ = last_reset_;
  last_reset_ = counters_.steps;
}

void World::find_broken(bool gave_up) noexcept {
  DivergedTrees& broken = run_->diverged_trees;
  broken.clear();
  if (gave_up || !run_->mark_warned()) broken.mark_all();
  for (std::size_t i = 0; i < parts_; ++i)
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

Vec3 World::velocity_at(std::size_t object, const Vec3& point) const noexcept {
  if (object < still_ || object >= objects().size()) return Vec3::Zero();
  const Motion& motion = motions_[object - still_];
  return motion.linear + motion.angular.cross(point - objects()[object].pose.position);
}

void World::adopt(const Scene& scene) noexcept {
  for (std::size_t held = 0; held < held_.size(); ++held) {
    MovedView& moved = held_[held];
    moved.view = &scene.views()[held];
    for (std::size_t i = 0; i < moved.objects.size(); ++i)
      moved.objects[i].material = moved.view->objects()[i].material;
  }
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

void World::push(BodyContactState& contacts, TouchMemory& memory, double share) noexcept {
  if (memory.size() != objects().size() || contacts.nearness.size() != parts_) [[unlikely]]
    return;
  if (contacts.resets != counters_.resets) {
    contacts.fresh = false;
    forget_moving(contacts, memory);
  }
  if (!contacts.fresh) {
    Command unused;
    ask_near({contacts.tool.position, Vec3::Zero()}, memory, contacts, unused);
  }
  contacts.fresh = false;
  double force = 0.0;  // [N]
  for (const std::uint32_t part : contacts.near.parts) force += length(contacts.forces[part]);
  const double given = share * allowed(contacts, force);
  const NeighbourSearch& reach = held_[contacts.held].reach;
  for (const std::uint32_t part : contacts.near.parts)
    apply(part, contacts, reach.nearest(part, contacts.tool.position), given);
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

void World::push(BodyContactState& contacts, BodyMemory& memory, double share) noexcept {
  if (contacts.forces.size() != parts_) [[unlikely]]
    return;
  // Without a sample the hand is assumed to stand still.
  if (!contacts.fresh || contacts.resets != counters_.resets) {
    hold(contacts.device, tick_, memory, contacts);
    contacts.ahead += tick_;
  }
  contacts.fresh = false;
  double force = 0.0;  // [N]
  for (const Vec3& part : contacts.forces) force += length(part);
  const double given = share * allowed(contacts, force);
  for (std::size_t i = 0; i < parts_; ++i) apply(i, contacts, contacts.tool.position, given);
}

}  // namespace feltwire
