#include "core/scene/world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/numeric.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene/mujoco_guard.hpp"

namespace feltwire {
namespace {

constexpr double kSnapshotInterval = 0.1;  // [s]
constexpr std::size_t kSnapshots = 16;
constexpr int kFreeCoordinates = 7, kFreeSpeeds = 6;

}  // namespace

/// The MuJoCo side: state, and the ring of states that were good.
struct World::Run {
  struct Snapshot {
    std::vector<mjtNum> coordinates, activations;
    std::uint64_t step = 0;
  };

  explicit Run(const Mechanism& mechanism)
      : model(mechanism.model()), parts(mechanism.parts()), data(mujoco::make_data(model)) {
    if (data == nullptr)
      throw std::invalid_argument(
          "the bodies cannot be evaluated where they start; check the scene");
    initial = snapshot_of(0);
    ring.assign(kSnapshots, initial);
  }

  Snapshot snapshot_of(std::uint64_t step) const {
    return {{data->qpos, data->qpos + model.nq}, {data->act, data->act + model.na}, step};
  }
  void keep(std::uint64_t step) noexcept {
    newest = (newest + 1) % kSnapshots;
    kept = std::min(kept + 1, kSnapshots);
    Snapshot& place = ring[newest];
    std::copy_n(data->qpos, model.nq, place.coordinates.begin());
    std::copy_n(data->act, model.na, place.activations.begin());
    place.step = step;
  }
  /// Takes out of the ring all from the newest that is no younger than that step on.
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
    mj_resetData(&model, data.get());
    std::copy(to.coordinates.begin(), to.coordinates.end(), data->qpos);
    std::copy(to.activations.begin(), to.activations.end(), data->act);
  }

  /// Warnings of the last step that mean that its result is none: MuJoCo has then reset itself.
  bool broken() const noexcept {
    return data->warning[mjWARN_BADQPOS].number != 0 || data->warning[mjWARN_BADQVEL].number != 0 ||
           data->warning[mjWARN_BADQACC].number != 0;
  }
  std::uint64_t take_warnings() noexcept {
    std::uint64_t count = 0;
    for (const int kind : {mjWARN_INERTIA, mjWARN_CONTACTFULL, mjWARN_CNSTRFULL}) {
      count += static_cast<std::uint64_t>(data->warning[kind].number);
      data->warning[kind].number = 0;
    }
    return count;
  }
  /// Bodies that left for good begin anew; says how many.
  std::uint64_t put_back_lost() noexcept {
    std::uint64_t count = 0;
    for (int j = 0; j < model.njnt; ++j) {
      if (model.jnt_type[j] != mjJNT_FREE) continue;
      const int q = model.jnt_qposadr[j];
      if (!(length(Vec3(mujoco::vector(data->qpos + q) - mujoco::vector(model.qpos0 + q))) > kLost))
        continue;
      std::copy_n(model.qpos0 + q, kFreeCoordinates, data->qpos + q);
      std::fill_n(data->qvel + model.jnt_dofadr[j], kFreeSpeeds, 0.0);
      ++count;
    }
    return count;
  }

  const mjModel& model;
  const std::vector<Mechanism::Part>& parts;
  mujoco::Data data;
  Snapshot initial;
  std::vector<Snapshot> ring;
  std::size_t newest = 0, kept = 0;
};

namespace {

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
      run_(std::make_unique<Run>(mechanism_of(scene))) {
  const auto add = [&](const Scene& held) {
    std::vector<Reach> reaches(parts_);
    for (std::size_t i = 0; i < parts_; ++i) {
      const double radius = reach(held.objects()[still_ + i]) + held.tool().radius;
      reaches[i].square = radius * radius;
    }
    held_.push_back({&held, held.objects(), std::move(reaches)});
  };
  held_.reserve(1 + scene.others().size());
  add(scene);
  for (const auto& other : scene.others()) add(*other);
  look();
}

World::~World() = default;

/// Poses and velocities as MuJoCo has them after mj_step1.
void World::look() noexcept {
  for (std::size_t i = 0; i < parts_; ++i) {
    const Mechanism::Part& part = run_->parts[i];
    const Quaternion turned = mujoco::quaternion(mujoco::entry<4>(run_->data->xquat, part.body));
    const Vec3 arm = turned * part.in_body.position;
    Pose pose;
    pose.position = mujoco::vector(mujoco::entry<3>(run_->data->xpos, part.body)) + arm;
    pose.orientation = (turned * part.in_body.orientation).normalized();
    std::array<mjtNum, 6> velocity{};  // of the body's frame, world axes: angular, linear
    mj_objectVelocity(&run_->model, run_->data.get(), mjOBJ_XBODY, part.body, velocity.data(), 0);
    for (Held& held : held_) {
      held.objects[still_ + i].pose = pose;
      held.reaches[i].center = pose.position;
    }
    Motion& motion = motions_[i];
    motion.angular = mujoco::vector(velocity.data());
    motion.linear = mujoco::vector(velocity.data() + 3) + motion.angular.cross(arm);
  }
}

bool World::sane() const noexcept {
  if (run_->broken()) return false;
  for (std::size_t i = 0; i < parts_; ++i) {  // written so that a NaN is not sane
    if (!(length(motions_[i].linear) <= kLargestSpeed)) return false;
    if (!(length(motions_[i].angular) <= kLargestTurn)) return false;
    const Pose& pose = objects()[still_ + i].pose;
    if (!pose.position.allFinite() || !pose.orientation.coeffs().allFinite()) return false;
  }
  return true;
}

bool World::step() noexcept {
  const mjModel& model = run_->model;
  mjData* data = run_->data.get();
  // The second half of MuJoCo's step moves on; the first makes ready, so that the places are those
  // of now between two steps.
  bool done = mujoco::guarded([&] { mj_step2(&model, data); });
  std::fill_n(data->qfrc_applied, model.nv, 0.0);
  if (done) counters_.returned += run_->put_back_lost();
  done = done && mujoco::guarded([&] { mj_step1(&model, data); });
  counters_.warnings += run_->take_warnings();
  ++counters_.steps;
  trust_ = std::min(1.0, trust_ + tick_ / kRecovery);
  if (done) look();
  if (!done || !sane()) {
    go_back();
    return false;
  }
  const auto interval = static_cast<std::uint64_t>(std::llround(kSnapshotInterval / tick_));
  if (counters_.steps % interval == 0) run_->keep(counters_.steps);
  return true;
}

void World::go_back() noexcept {
  const auto age = static_cast<std::uint64_t>(std::llround(kGoodAge / tick_));
  const std::uint64_t before = counters_.steps > age ? counters_.steps - age : 0;
  run_->restore(run_->take_before(before));
  if (!mujoco::guarded([&] { mj_step1(&run_->model, run_->data.get()); }) || run_->broken())
      [[unlikely]] {
    run_->restore(run_->initial);  // it was evaluated once
    mujoco::guarded([&] { mj_step1(&run_->model, run_->data.get()); });
  }
  look();
  trust_ = 0.0;
  ++counters_.resets;
}

Vec3 World::velocity_at(std::size_t object, const Vec3& point) const noexcept {
  if (object < still_ || object >= objects().size()) return Vec3::Zero();
  const Motion& motion = motions_[object - still_];
  return motion.linear + motion.angular.cross(point - objects()[object].pose.position);
}

Vec3 World::momentum() const noexcept {
  Vec3 sum = Vec3::Zero();
  for (int body = 1; body < run_->model.nbody; ++body) {
    std::array<mjtNum, 6> velocity{};  // of the centre of mass
    mj_objectVelocity(&run_->model, run_->data.get(), mjOBJ_BODY, body, velocity.data(), 0);
    sum += run_->model.body_mass[body] * mujoco::vector(velocity.data() + 3);
  }
  return sum;
}

void World::forget_moving(Grasp& grasp, TouchMemory& memory) const noexcept {
  for (std::size_t i = still_; i < memory.size(); ++i) memory[i] = {};
  grasp.resets = counters_.resets;
}

/// Keeps what a moving object answers in the grasp and adds it to `sum`. One that has gone out of
/// reach is asked once more, and lets go.
void World::ask(const Held& held, std::size_t part, const Tool& tool, TouchMemory& memory,
                Grasp& grasp, Command& sum) const noexcept {
  const Reach& within = held.reaches[part];
  const bool far = (tool.position - within.center).squaredNorm() > within.square;
  if (far && grasp.asked[part] == 0) return;
  grasp.asked[part] = far ? 0 : 1;
  const std::size_t object = still_ + part;
  const Vec3 against = tool.velocity - velocity_at(object, tool.position);
  const Command answer = trust_ * feltwire::touch(held.objects[object], {tool.position, against},
                                                  memory[object], held.scene->tool().radius);
  grasp.forces[part] = answer.force();
  sum.elastic += answer.elastic;
  sum.frictional += answer.frictional;
}

Command World::touch(const Tool& tool, TouchMemory& memory, Grasp& grasp) const noexcept {
  if (!tool.position.allFinite() || !tool.velocity.allFinite() ||
      memory.size() != objects().size() || grasp.forces.size() != parts_ ||
      grasp.asked.size() != parts_) [[unlikely]]
    return {};
  if (grasp.resets != counters_.resets) forget_moving(grasp, memory);
  const Held& held = held_[grasp.held];
  Command sum = held.scene->touch_still(tool, memory);
  grasp.tool = tool;
  grasp.fresh = true;
  for (std::size_t i = 0; i < parts_; ++i) ask(held, i, tool, memory, grasp, sum);
  return sum.finite() ? sum : Command{};
}

void World::push(Grasp& grasp, TouchMemory& memory, double share) noexcept {
  if (memory.size() != objects().size() || grasp.forces.size() != parts_ ||
      grasp.asked.size() != parts_) [[unlikely]]
    return;
  if (grasp.resets != counters_.resets) grasp.fresh = false;
  if (!grasp.fresh) {
    const Tool standing{grasp.tool.position, Vec3::Zero()};
    if (grasp.resets != counters_.resets) forget_moving(grasp, memory);
    Command unused;
    for (std::size_t i = 0; i < parts_; ++i)
      ask(held_[grasp.held], i, standing, memory, grasp, unused);
  }
  apply(grasp, share);
}

void World::apply(Grasp& grasp, double share) noexcept {
  grasp.fresh = false;
  for (std::size_t i = 0; i < parts_; ++i) {
    const Vec3 force = -share * grasp.forces[i], torque = -share * grasp.torques[i];
    if ((force.isZero(0.0) && torque.isZero(0.0)) || !force.allFinite() || !torque.allFinite())
      continue;
    mj_applyFT(&run_->model, run_->data.get(), force.data(), torque.data(),
               grasp.tool.position.data(), run_->parts[i].body, run_->data->qfrc_applied);
  }
}

void World::push(Grasp& grasp, BodyMemory& memory, double share) noexcept {
  if (grasp.forces.size() != parts_) [[unlikely]]
    return;
  // Where no sample came the hand is taken to stand.
  if (!grasp.fresh || grasp.resets != counters_.resets) hold(grasp.device, tick_, memory, grasp);
  apply(grasp, share);
}

}  // namespace feltwire
