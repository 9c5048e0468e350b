#include "sim/arm/arm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/base/file_error.hpp"
#include "core/base/numeric.hpp"
#include "core/base/splitmix.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/dynamics/mujoco_sort.hpp"
#include "sim/arm/arm_model.hpp"
#include "sim/arm/impedance.hpp"

namespace feltwire {
namespace {

constexpr double kTouches = 1.0;    // [N]
constexpr double kMostNoise = 4.0;  // RMS, in length: more is cut

void check(double value, const char* name, bool zero_is_allowed) {
  if (std::isfinite(value) && (value > 0.0 || (zero_is_allowed && value == 0.0))) return;
  throw std::invalid_argument(std::string("arm: ") + name + " is " + std::to_string(value) +
                              "; give a finite number " +
                              (zero_is_allowed ? "of 0 or more" : "above 0"));
}

ArmConfig checked(const ArmConfig& c) {
  check(c.servo_period, "servo_period", false);
  check(c.stiffness, "stiffness", false);
  check(c.turning_stiffness, "turning_stiffness", false);
  check(c.damping_ratio, "damping_ratio", false);
  check(c.posture_stiffness, "posture_stiffness", true);
  check(c.largest_pull, "largest_pull", false);
  check(c.largest_turn, "largest_turn", false);
  check(c.stop_force, "stop_force", false);
  check(c.stop_torque, "stop_torque", false);
  check(c.noise, "noise", true);
  check(c.torque_noise, "torque_noise", true);
  if (c.gripper) check(*c.gripper, "gripper", true);
  return c;
}

/// Three normal numbers of variance 1 (Box and Muller), in length at most kMostNoise.
Vec3 noise(std::uint64_t seed, std::uint64_t n) noexcept {
  constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
  constexpr int kSpare = 11;                          // bits that a double cannot hold
  constexpr std::uint64_t kDraws = 4;
  const auto uniform = [&](std::uint64_t i) {  // in (0, 1]
    return (static_cast<double>(splitmix::draw(seed, kDraws * n + i) >> kSpare) + 1.0) * kUnit;
  };
  const auto normal = [&](std::uint64_t size, double turn) {
    return std::sqrt(-2.0 * std::log(uniform(size))) * std::cos(2.0 * std::numbers::pi * turn);
  };
  const Vec3 v(normal(0, uniform(1)), normal(0, uniform(1) + 0.25), normal(2, uniform(3)));
  const double size = length(v);
  return size > kMostNoise ? Vec3(kMostNoise / size * v) : v;
}

/// [N s/m] The friction of the axes, seen at the tool, at least: by Cauchy and Schwarz
/// |v|^2 <= (sum r_i |q_i'|)^2 <= sum d_i q_i'^2 sum r_i^2 / d_i, with r_i the most that the tool
/// can be away from axis i.
double least_damping(const arm::ArmModel& arm) {
  const mjModel& model = *arm.model;
  double reach = mujoco::vector(mujoco::entry<3>(model.site_pos, arm.tool)).norm(), sum = 0.0;
  int body = arm.hand;
  for (std::size_t i = arm.axes.size(); i-- > 0;) {
    const arm::Axis& axis = arm.axes.at(i);
    for (const int own = model.jnt_bodyid[axis.joint]; body != own && body > 0;
         body = model.body_parentid[body])
      reach += mujoco::vector(mujoco::entry<3>(model.body_pos, body)).norm();
    sum += reach * reach / model.dof_damping[axis.speed];
  }
  return 1.0 / sum;
}

}  // namespace

struct Arm::Simulation {
  Simulation(const ArmConfig& config, arm::ArmModel&& loaded)
      : arm(std::move(loaded)), data(evaluated(config, arm)), control(config, arm, *data) {}

  /// The arm at home.
  static mujoco::Data evaluated(const ArmConfig& config, const arm::ArmModel& arm) {
    mujoco::bring_own_sort();
    const mjModel& model = *arm.model;
    mujoco::Data data = mujoco::make_data(model);
    if (data != nullptr) {
      for (int i = 0; i < arm::kAxes; ++i)
        data->qpos[arm.axes.at(static_cast<std::size_t>(i)).position] = arm.home[i];
      if (arm.fingers)
        for (const arm::Axis& finger : *arm.fingers)
          data->qpos[finger.position] =
              config.gripper ? std::clamp(0.5 * *config.gripper, finger.low, finger.high)
                             : finger.high;
      if (mujoco::guarded([&] { mj_step1(&model, data.get()); })) return data;
    }
    throw FileError(config.file.string() + ": MuJoCo cannot evaluate it where it starts");
  }

  arm::ArmModel arm;
  mujoco::Data data;
  arm::Impedance control;
  Vec3 pushed = Vec3::Zero();  // [N] on the tool
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};

Arm::Arm(const ArmConfig& config)
    : config_(checked(config)),
      sim_(std::make_unique<Simulation>(config_, arm::load_arm(config_.file))) {
  const double step = sim_->arm.model->opt.timestep;
  const double steps = config_.servo_period / step;
  constexpr double kRounding = 1e-6;
  if (steps < 1.0 - kRounding || std::abs(steps - std::round(steps)) > kRounding)
    throw FileError(config_.file.string() + ": its timestep of " + std::to_string(step) +
                    " s does not divide the servo period of " +
                    std::to_string(config_.servo_period) + " s; change <option timestep>");
  spec_.name = "arm";
  spec_.servo_period = config_.servo_period;
  spec_.stiffness = config_.stiffness;
  spec_.damping = sim_->control.damping();
  spec_.own_damping = least_damping(sim_->arm);
  spec_.mass = sim_->control.mass();
  spec_.wrench_noise = kMostNoise * config_.noise;
  if (sim_->arm.fingers) spec_.gripper_opening = 2.0 * sim_->arm.fingers->front().high;
  const mjData& data = *sim_->data;
  FollowerTarget first{sim_->control.tool(data).pose, spec_.gripper_opening};
  if (config_.gripper) first.gripper = *config_.gripper;
  sim_->control.aim(first, sim_->control.tool(data));
  sense();
}

Arm::~Arm() = default;

FollowerReading Arm::read(Nanoseconds now) noexcept {
  if (!begun_) {
    begun_ = true;
    start_ = now;
  }
  if (held_.load() && !halted_) {
    halted_ = true;
    halt();
  }
  constexpr double kLongest = 1.0;  // [s]
  const double step_length = sim_->arm.model->opt.timestep;
  const std::int64_t due = std::llround(seconds(now - start_) / step_length);
  const std::int64_t most = std::llround(kLongest / step_length);
  const std::int64_t count = std::clamp<std::int64_t>(due - steps_, 0, most);
  const bool touching = reading_.force && length(*reading_.force) > kTouches;
  sim_->control.spread(static_cast<int>(count), touching);
  for (std::int64_t i = 0; i < count && reading_.ok; ++i) step();
  steps_ = std::max(steps_, due);
  if (count > 0) sense();
  return reading_;
}

FollowerTarget Arm::write(const FollowerTarget& target) noexcept {
  arm::Impedance& control = sim_->control;
  if (reading_.ok && !reading_.stopped && !held_.load())
    control.aim(target, control.tool(*sim_->data));
  return control.target();
}

void Arm::resume() noexcept { reading_.stopped = false; }

void Arm::push(const Vec3& force) noexcept {
  if (force.allFinite()) sim_->pushed = force;
}

void Arm::halt() noexcept { sim_->control.hold(sim_->control.tool(*sim_->data)); }

/// One step of physics with its control; the force that acted in it.
void Arm::step() noexcept {
  const mjModel& model = *sim_->arm.model;
  mjData& data = *sim_->data;
  const int hand = sim_->arm.hand;
  const Vec3 lever = mujoco::vector(mujoco::entry<3>(data.site_xpos, sim_->arm.tool)) -
                     mujoco::vector(mujoco::entry<3>(data.xipos, hand));
  const Vec3 moment = lever.cross(sim_->pushed);
  mjtNum* const applied = data.xfrc_applied + std::ptrdiff_t{6} * hand;
  std::copy_n(sim_->pushed.data(), 3, applied);
  std::copy_n(moment.data(), 3, applied + 3);
  const bool done = mujoco::guarded([&] {
    sim_->control.drive(data);
    mj_step2(&model, &data);
  });
  // The wrist's frame is that of the step's beginning, as the sensors' numbers are.
  using Frame = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  const Mat3 turned = Frame(mujoco::entry<9>(data.site_xmat, sim_->arm.wrist));
  const Vec3 held = mujoco::vector(data.sensordata + sim_->arm.force);
  const Vec3 twisted = mujoco::vector(data.sensordata + sim_->arm.torque);
  const Vec3 inertial =
      sim_->arm.tool_mass * mujoco::vector(data.sensordata + sim_->arm.acceleration);
  const Vec3 at_wrist = mujoco::vector(mujoco::entry<3>(model.site_pos, sim_->arm.wrist));
  const Vec3 balance =
      mujoco::vector(mujoco::entry<3>(model.site_pos, sim_->arm.balance)) - at_wrist;
  const Vec3 tool = mujoco::vector(mujoco::entry<3>(model.site_pos, sim_->arm.tool)) - at_wrist;
  const Vec3 force = inertial - held;
  const Vec3 torque = balance.cross(inertial) - twisted - tool.cross(force);
  sim_->force = turned * force;
  sim_->torque = turned * torque;
  reading_.ok =
      done && sim_->force.allFinite() && sim_->torque.allFinite() &&
      data.warning[mjWARN_BADQPOS].number == 0 && data.warning[mjWARN_BADQVEL].number == 0 &&
      data.warning[mjWARN_BADQACC].number == 0 && mujoco::guarded([&] { mj_step1(&model, &data); });
  const bool too_much =
      length(sim_->force) > config_.stop_force || length(sim_->torque) > config_.stop_torque;
  if (reading_.ok && too_much && !reading_.stopped) {
    reading_.stopped = true;
    halt();
  }
}

/// The reading after the last step.
void Arm::sense() noexcept {
  if (!reading_.ok) return;
  const arm::ToolState tool = sim_->control.tool(*sim_->data);
  reading_.pose = tool.pose;
  reading_.velocity = tool.velocity;
  reading_.angular_velocity = tool.angular_velocity;
  const auto n = static_cast<std::uint64_t>(steps_);
  constexpr std::uint64_t kOther = 0x746f72717565ULL;  // the torque's noise is another
  reading_.force = sim_->force + config_.noise * noise(config_.seed, n);
  reading_.torque = sim_->torque + config_.torque_noise * noise(config_.seed ^ kOther, n);
  reading_.commanded = sim_->control.target().pose;
  if (!sim_->arm.fingers) return;
  reading_.gripper = 0.0;
  for (const arm::Axis& finger : *sim_->arm.fingers)
    reading_.gripper += sim_->data->qpos[finger.position];
  reading_.gripper_force = sim_->control.grip();
}

Vec3 Arm::contact_force() const noexcept {
  const mjModel& model = *sim_->arm.model;
  Vec3 sum = Vec3::Zero();
  for (int body = sim_->arm.hand; body < model.nbody; ++body) {
    int above = body;  // up to the hand, which has a lower number than all that it carries
    while (above > sim_->arm.hand) above = model.body_parentid[above];
    if (above == sim_->arm.hand)
      sum += mujoco::vector(mujoco::entry<6>(sim_->data->cfrc_ext, body) + 3);
  }
  return sum;
}

double Arm::energy() const noexcept {
  const mjModel& model = *sim_->arm.model;
  const mjData& data = *sim_->data;
  // The last rows of the mass matrix may be of other bodies; they move by themselves.
  double sum = sim_->control.energy(data);
  for (int body = 1; body < model.nbody; ++body) {
    if (model.body_rootid[body] != model.body_rootid[sim_->arm.hand]) continue;
    mjtNum velocity[6];
    mj_objectVelocity(&model, &data, mjOBJ_BODY, body, velocity, 1);
    const mjtNum* inertia = mujoco::entry<3>(model.body_inertia, body);
    const Vec3 turning = mujoco::vector(velocity), moving = mujoco::vector(velocity + 3);
    sum += 0.5 * (model.body_mass[body] * moving.squaredNorm() +
                  mujoco::vector(inertia).dot(turning.cwiseAbs2()));
  }
  for (const arm::Axis& axis : sim_->arm.axes)
    sum += 0.5 * model.dof_armature[axis.speed] * data.qvel[axis.speed] * data.qvel[axis.speed];
  return sum;
}

double Arm::angle(int axis) const noexcept {
  return sim_->data->qpos[sim_->arm.axes[static_cast<std::size_t>(axis)].position];
}

double Arm::torque(int axis) const noexcept {
  return sim_->data->ctrl[sim_->arm.axes[static_cast<std::size_t>(axis)].motor];
}

Arm::Limits Arm::limits(int axis) const noexcept {
  const arm::Axis& a = sim_->arm.axes[static_cast<std::size_t>(axis)];
  return {a.low, a.high, a.most};
}

std::optional<Vec3> Arm::place_of(const std::string& body) const {
  const int id = mj_name2id(sim_->arm.model.get(), mjOBJ_BODY, body.c_str());
  if (id < 0) return std::nullopt;
  return mujoco::vector(mujoco::entry<3>(sim_->data->xpos, id));
}

FollowerTarget bring(Arm& arm, const Vec3& place, double gripper, Nanoseconds& now) noexcept {
  constexpr double kTime = 3.0, kRest = 1.0;  // [s]
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
