#include "client/simulated_robots/arm.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/arm/driven_arm_inside.hpp"
#include "core/base/file_error.hpp"
#include "core/base/json_document.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/dynamics/mujoco_sort.hpp"
#include "core/scene/validation.hpp"

namespace feltwire {
namespace {

const ArmConfig& checked(const ArmConfig& config) {
  if (const auto violation = check(config)) refuse("arm", *violation);
  if (!(config.servo_period > 0.0) || !std::isfinite(config.servo_period))
    refuse("arm", {"servo_period",
                   "is " + number_text(config.servo_period) + "; give a finite number above 0"});
  return config;
}

mujoco::Model loaded(const std::string& file) {
  read_text(file);  // throws an error with a clearer message than MuJoCo's
  mujoco::Loaded loaded = mujoco::load_file(file);
  if (loaded.model == nullptr) throw FileError(file + ": " + loaded.error);
  // Refuse other integrators: mj_step1() and mj_step2() together are one step of the Euler
  // integrator, but not of Runge-Kutta.
  if (loaded.model->opt.integrator != mjINT_EULER)
    throw FileError(file +
                    ": its integrator is not Euler; remove integrator=\"...\" from <option>");
  return std::move(loaded.model);
}

/// Returns MuJoCo's data with the arm in its home pose.
mujoco::Data evaluated(const ArmConfig& config, const mjModel& model) {
  mujoco::bring_own_sort();
  mujoco::Data data = mujoco::make_data(model);
  if (data != nullptr) {
    go_home(model, config.file.string(), config, data->qpos);
    if (mujoco::guarded([&] { mj_step1(&model, data.get()); })) return data;
  }
  throw FileError(config.file.string() + ": MuJoCo cannot evaluate it where it starts");
}

}  // namespace

struct Arm::Simulation {
  explicit Simulation(const ArmConfig& config)
      : model(loaded(config.file.string())),
        data(evaluated(config, *model)),
        arm(config, config.servo_period, config.file.string(), *model, *data) {}

  const arm::ArmParts& parts() const { return arm.inside().parts; }

  mujoco::Model model;
  mujoco::Data data;
  DrivenArm arm;
  Vec3 pushed = Vec3::Zero();  // [N] external force on the tool
};

Arm::Arm(const ArmConfig& config) : sim_(std::make_unique<Simulation>(checked(config))) {
  const double step = sim_->model->opt.timestep;
  const double steps = config.servo_period / step;
  constexpr double kRounding = 1e-6;
  if (steps < 1.0 - kRounding || std::abs(steps - std::round(steps)) > kRounding)
    throw FileError(config.file.string() + ": its timestep of " + std::to_string(step) +
                    " s does not divide the servo period of " +
                    std::to_string(config.servo_period) + " s; change <option timestep>");
}

Arm::~Arm() = default;

const FollowerSpec& Arm::spec() const { return sim_->arm.spec(); }

FollowerReading Arm::read(Nanoseconds now) noexcept {
  if (!begun_) {
    begun_ = true;
    start_ = now;
  }
  DrivenArm& arm = sim_->arm;
  if (held_.load() && !halted_) {
    halted_ = true;
    arm.hold(*sim_->data);
  }
  constexpr double kLongest = 1.0;  // [s] longest time to simulate in one call
  const double step_length = sim_->model->opt.timestep;
  const std::int64_t due = std::llround(seconds(now - start_) / step_length);
  const std::int64_t most = std::llround(kLongest / step_length);
  const std::int64_t count = std::clamp<std::int64_t>(due - steps_, 0, most);
  arm.spread(static_cast<int>(count));
  for (std::int64_t i = 0; i < count && arm.reading().ok; ++i) step();
  steps_ = std::max(steps_, due);
  return count > 0 ? arm.read(*sim_->data, static_cast<std::uint64_t>(steps_)) : arm.reading();
}

FollowerTarget Arm::write(const FollowerTarget& target) noexcept {
  return held_.load() ? sim_->arm.target() : sim_->arm.aim(target, *sim_->data);
}

void Arm::resume() noexcept { sim_->arm.resume(); }

void Arm::push(const Vec3& force) noexcept {
  if (force.allFinite()) sim_->pushed = force;
}

/// Applies the external force and the motor torques, advances the simulation by one step, and
/// updates the reading of the force sensor.
void Arm::step() noexcept {
  const mjModel& model = *sim_->model;
  mjData& data = *sim_->data;
  const int hand = sim_->parts().hand;
  const Vec3 lever = mujoco::vector(mujoco::entry<3>(data.site_xpos, sim_->parts().tool)) -
                     mujoco::vector(mujoco::entry<3>(data.xipos, hand));
  const Vec3 moment = lever.cross(sim_->pushed);
  mjtNum* const applied = data.xfrc_applied + std::ptrdiff_t{6} * hand;
  std::copy_n(sim_->pushed.data(), 3, applied);
  std::copy_n(moment.data(), 3, applied + 3);
  const bool moved = sim_->arm.drive(data) && mujoco::guarded([&] { mj_step2(&model, &data); });
  const bool done = sim_->arm.weigh(data) && moved && data.warning[mjWARN_BADQPOS].number == 0 &&
                    data.warning[mjWARN_BADQVEL].number == 0 &&
                    data.warning[mjWARN_BADQACC].number == 0 &&
                    mujoco::guarded([&] { mj_step1(&model, &data); });
  sim_->arm.judge(done, data);
}

Vec3 Arm::contact_force() const noexcept {
  const mjModel& model = *sim_->model;
  Vec3 sum = Vec3::Zero();
  for (int body = sim_->parts().hand; body < model.nbody; ++body) {
    int above = body;  // goes up from parent to parent, at most to the hand
    while (above > sim_->parts().hand) above = model.body_parentid[above];
    if (above == sim_->parts().hand)
      sum += mujoco::vector(mujoco::entry<6>(sim_->data->cfrc_ext, body) + 3);
  }
  return sum;
}

double Arm::energy() const noexcept {
  const mjModel& model = *sim_->model;
  const mjData& data = *sim_->data;
  // The mass matrix may also contain other moving bodies, so sum over the arm's own bodies instead.
  double sum = sim_->arm.inside().impedance.energy(data);
  for (int body = 1; body < model.nbody; ++body) {
    if (model.body_rootid[body] != model.body_rootid[sim_->parts().hand]) continue;
    mjtNum velocity[6];
    mj_objectVelocity(&model, &data, mjOBJ_BODY, body, velocity, 1);
    const mjtNum* inertia = mujoco::entry<3>(model.body_inertia, body);
    const Vec3 turning = mujoco::vector(velocity), moving = mujoco::vector(velocity + 3);
    sum += 0.5 * (model.body_mass[body] * moving.squaredNorm() +
                  mujoco::vector(inertia).dot(turning.cwiseAbs2()));
  }
  for (const arm::Axis& axis : sim_->parts().axes)
    sum += 0.5 * model.dof_armature[axis.speed] * data.qvel[axis.speed] * data.qvel[axis.speed];
  return sum;
}

double Arm::angle(int axis) const noexcept {
  return sim_->data->qpos[sim_->parts().axes[static_cast<std::size_t>(axis)].position];
}

double Arm::torque(int axis) const noexcept {
  return sim_->data->ctrl[sim_->parts().axes[static_cast<std::size_t>(axis)].motor];
}

Arm::Limits Arm::limits(int axis) const noexcept {
  const arm::Axis& a = sim_->parts().axes[static_cast<std::size_t>(axis)];
  return {a.low, a.high, a.most};
}

std::optional<Vec3> Arm::place_of(const std::string& body) const {
  const int id = mj_name2id(sim_->model.get(), mjOBJ_BODY, body.c_str());
  if (id < 0) return std::nullopt;
  return mujoco::vector(mujoco::entry<3>(sim_->data->xpos, id));
}

FollowerTarget bring(Arm& arm, const Vec3& place, double gripper, Nanoseconds& now) noexcept {
  constexpr double kTime = 3.0, kRest = 1.0;  // [s] movement to `place`, then rest
  const double period = arm.spec().servo_period;
  FollowerTarget target{arm.read(now).pose, gripper};
  const Vec3 from = target.pose.position;
  double t = 0.0;
  while (t < kTime + kRest) {
    target.pose.position = from + std::min(1.0, t / kTime) * (place - from);
    arm.write(target);
    now += from_seconds(period);
    arm.read(now);
    t += period;
  }
  return target;
}

}  // namespace feltwire
