#include "core/arm/driven_arm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/arm/driven_arm_inside.hpp"
#include "core/base/numeric.hpp"
#include "core/base/splitmix.hpp"

namespace feltwire {
namespace {

constexpr double kTouches = 1.0;  // [N] A tool that measures more force is in contact.
// Largest length of the noise vector; the RMS value of a component is 1.
constexpr double kMostNoise = 4.0;

/// Returns a vector of three normally distributed random numbers of variance 1 (Box-Muller method).
/// Shortens a vector that is longer than kMostNoise.
Vec3 noise(std::uint64_t seed, std::uint64_t n) noexcept {
  constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
  constexpr int kSpare = 11;  // number of bits of a draw that a double cannot hold
  constexpr std::uint64_t kDraws = 4;
  const auto uniform = [&](std::uint64_t i) {  // returns a random number in (0, 1]
    return (static_cast<double>(splitmix::draw(seed, kDraws * n + i) >> kSpare) + 1.0) * kUnit;
  };
  const auto normal = [&](std::uint64_t size, double turn) {
    return std::sqrt(-2.0 * std::log(uniform(size))) * std::cos(2.0 * std::numbers::pi * turn);
  };
  const Vec3 v(normal(0, uniform(1)), normal(0, uniform(1) + 0.25), normal(2, uniform(3)));
  const double size = length(v);
  return size > kMostNoise ? Vec3(kMostNoise / size * v) : v;
}

/// Returns a lower bound [N s/m] of the damping at the tool that the friction of the axes causes.
/// By the Cauchy-Schwarz inequality, |v|^2 <= (sum r_i |q_i'|)^2 <= sum d_i q_i'^2 sum r_i^2 / d_i.
/// Here v is the velocity of the tool, q_i' the speed of axis i, d_i its damping and r_i an upper
/// bound of its distance from the tool.
double least_damping(const arm::ArmParts& arm, const mjModel& model) {
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

DrivenArm::DrivenArm(const ArmControl& control, double servo_period, const std::string& file,
                     const mjModel& model, const mjData& data)
    : inside_(std::make_unique<Inside>(control, file, model, data)) {
  FollowerSpec& spec = inside_->spec;
  const arm::Impedance& impedance = inside_->impedance;
  spec.name = "arm";
  spec.servo_period = servo_period;
  spec.stiffness = control.stiffness;
  spec.damping = impedance.damping();
  spec.own_damping = least_damping(inside_->parts, model);
  spec.mass = impedance.mass();
  spec.wrench_noise = kMostNoise * control.noise;
  if (inside_->parts.fingers) spec.gripper_opening = 2.0 * inside_->parts.fingers->front().high;
  FollowerTarget first{impedance.tool(data).pose, spec.gripper_opening};
  if (control.gripper) first.gripper = *control.gripper;
  aim(first, data);
  read(data, 0);
}

DrivenArm::~DrivenArm() = default;
DrivenArm::DrivenArm(DrivenArm&&) noexcept = default;
DrivenArm& DrivenArm::operator=(DrivenArm&&) noexcept = default;

const FollowerSpec& DrivenArm::spec() const noexcept { return inside_->spec; }
const FollowerReading& DrivenArm::reading() const noexcept { return inside_->reading; }
const FollowerTarget& DrivenArm::target() const noexcept { return inside_->impedance.target(); }

const FollowerTarget& DrivenArm::aim(const FollowerTarget& target, const mjData& data) noexcept {
  arm::Impedance& impedance = inside_->impedance;
  if (inside_->reading.ok && !inside_->reading.stopped) impedance.aim(target, impedance.tool(data));
  return impedance.target();
}

void DrivenArm::hold(const mjData& data) noexcept {
  inside_->impedance.hold(inside_->impedance.tool(data));
}

void DrivenArm::spread(int steps) noexcept {
  const FollowerReading& reading = inside_->reading;
  inside_->impedance.spread(steps, reading.force && length(*reading.force) > kTouches);
}

bool DrivenArm::drive(mjData& data) noexcept {
  // Store the orientation of the wrist at the beginning of the step, because the sensors measure in
  // this frame.
  using Frame = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  inside_->wrist = Frame(mujoco::entry<9>(data.site_xmat, inside_->parts.wrist));
  arm::Impedance& impedance = inside_->impedance;
  return mujoco::guarded([&] { impedance.drive(data); });
}

bool DrivenArm::weigh(const mjData& data) noexcept {
  const mjModel& model = inside_->model;
  const arm::ArmParts& parts = inside_->parts;
  const Vec3 held = mujoco::vector(data.sensordata + parts.force);
  const Vec3 twisted = mujoco::vector(data.sensordata + parts.torque);
  const Vec3 inertial = parts.tool_mass * mujoco::vector(data.sensordata + parts.acceleration);
  const Vec3 at_wrist = mujoco::vector(mujoco::entry<3>(model.site_pos, parts.wrist));
  const Vec3 balance = mujoco::vector(mujoco::entry<3>(model.site_pos, parts.balance)) - at_wrist;
  const Vec3 tool = mujoco::vector(mujoco::entry<3>(model.site_pos, parts.tool)) - at_wrist;
  const Vec3 force = inertial - held;
  const Vec3 torque = balance.cross(inertial) - twisted - tool.cross(force);
  inside_->force = inside_->wrist * force;
  inside_->torque = inside_->wrist * torque;
  return inside_->force.allFinite() && inside_->torque.allFinite();
}

void DrivenArm::judge(bool done, const mjData& data) noexcept {
  FollowerReading& reading = inside_->reading;
  reading.ok = done;
  const bool too_much = length(inside_->force) > inside_->control.stop_force ||
                        length(inside_->torque) > inside_->control.stop_torque;
  if (!done || !too_much || reading.stopped) return;
  reading.stopped = true;
  hold(data);
}

bool DrivenArm::is_calm() const noexcept {
  return length(inside_->force) < 0.5 * inside_->control.stop_force &&
         length(inside_->torque) < 0.5 * inside_->control.stop_torque;
}

const FollowerReading& DrivenArm::read(const mjData& data, std::uint64_t n) noexcept {
  FollowerReading& reading = inside_->reading;
  if (!reading.ok) return reading;
  const arm::ToolState tool = inside_->impedance.tool(data);
  const ArmControl& control = inside_->control;
  reading.pose = tool.pose;
  reading.velocity = tool.velocity;
  reading.angular_velocity = tool.angular_velocity;
  // Another seed, so that the noise of the torque does not depend on that of the force.
  constexpr std::uint64_t kOther = 0x746f72717565ULL;
  reading.force = inside_->force + control.noise * noise(control.seed, n);
  reading.torque = inside_->torque + control.torque_noise * noise(control.seed ^ kOther, n);
  reading.commanded = target().pose;
  if (!inside_->parts.fingers) return reading;
  reading.gripper = 0.0;
  for (const arm::Axis& finger : *inside_->parts.fingers)
    reading.gripper += data.qpos[finger.position];
  reading.gripper_force = inside_->impedance.grip();
  return reading;
}

void DrivenArm::resume() noexcept { inside_->reading.stopped = false; }

void DrivenArm::put_back(const mjData& data) noexcept {
  inside_->force.setZero();
  inside_->torque.setZero();
  hold(data);
}

void go_home(const mjModel& model, const std::string& file, const ArmControl& control,
             double* coordinates) {
  arm::go_home(arm::find_arm(model, file, control.prefix), control.gripper, coordinates);
}

}  // namespace feltwire
