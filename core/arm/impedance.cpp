#include "core/arm/impedance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/base/clamp_length.hpp"
#include "core/base/numeric.hpp"

namespace feltwire::arm {
namespace {

constexpr int kWays = 6, kLinear = 3;
// [Hz] cutoff frequency of the low-pass filter for the target's velocity
constexpr double kReferenceRate = 20.0;
constexpr double kFastest = 0.5;         // [m/s] largest accepted speed of the target
constexpr double kFastestTurn = 2.0;     // [rad/s] largest accepted angular speed of the target
constexpr double kPostureDamping = 1.0;  // [N m s/rad] damping at a posture stiffness of 1 N m/rad
constexpr double kWall = 300.0;  // [N m/rad] stiffness of the virtual wall before a joint limit
constexpr double kWallDamping = 5.0;  // [N m s/rad] damping of this wall
constexpr double kBefore = 0.1;       // [rad] distance of this wall from the joint limit
// The mean of the gripper's fingers follows the target with this stiffness [N/m] and damping [N
// s/m].
constexpr double kGrip = 4000.0, kGripDamping = 40.0;
constexpr double kLevel = 10000.0, kLevelDamping = 100.0;  // [N/m], [N s/m] for a zero difference

using feltwire::clamp_length;

/// Limits the lengths of the linear and the angular part separately.
Vec6 clamp_length(const Vec6& v, double linear, double angular) {
  Vec6 out;
  out << clamp_length(Vec3(v.head<3>()), linear), clamp_length(Vec3(v.tail<3>()), angular);
  return out;
}

bool is_orientation(const Quaternion& q) {
  const double square = q.squaredNorm();
  return std::isfinite(square) && std::abs(square - 1.0) < 0.01;
}

/// Returns the energy [J] of a spring that is stretched by `stretched` and has at most the force
/// `most`.
double stored(double stiffness, double stretched, double most) {
  const double free = most / stiffness;
  return stretched <= free ? 0.5 * stiffness * stretched * stretched
                           : most * (stretched - 0.5 * free);
}

}  // namespace

Impedance::Impedance(const ArmControl& control, const ArmParts& arm, const mjModel& model,
                     const mjData& data)
    : control_(control),
      arm_(arm),
      model_(model),
      rows_(static_cast<std::size_t>(kWays * model.nv)),
      solved_(rows_.size()) {
  find_jacobian(data);
  mj_solveM(&model_, const_cast<mjData*>(&data), solved_.data(), rows_.data(), kWays);
  using Rows = Eigen::Map<const Eigen::Matrix<double, kWays, Eigen::Dynamic, Eigen::RowMajor>>;
  const int speeds = model_.nv;
  const Mat6 mobility =
      Rows(rows_.data(), kWays, speeds) * Rows(solved_.data(), kWays, speeds).transpose();
  using Solver = Eigen::SelfAdjointEigenSolver<Mat3>;  // The eigenvalues are in ascending order.
  mass_ = 1.0 / Solver(mobility.topLeftCorner<3, 3>()).eigenvalues().y();
  const double inertia = 1.0 / Solver(mobility.bottomRightCorner<3, 3>()).eigenvalues().y();
  damping_ = 2.0 * control.damping_ratio * std::sqrt(control.stiffness * mass_);
  turning_damping_ = 2.0 * control.damping_ratio * std::sqrt(control.turning_stiffness * inertia);
  posture_damping_ = kPostureDamping * std::sqrt(control.posture_stiffness);
  share_ = 1.0 - std::exp(-2.0 * std::numbers::pi * kReferenceRate * model_.opt.timestep);
  hold(tool(data));
}

void Impedance::find_jacobian(const mjData& data) noexcept {
  const std::ptrdiff_t speeds = model_.nv;
  mjtNum* const rows = rows_.data();
  mj_jacSite(&model_, &data, rows, rows + kLinear * speeds, arm_.tool);
  for (int i = 0; i < kAxes; ++i)
    for (int way = 0; way < kWays; ++way)
      jacobian_(way, i) = rows[way * speeds + arm_.axes.at(static_cast<std::size_t>(i)).speed];
}

ToolState Impedance::tool(const mjData& data) const noexcept {
  ToolState state;
  state.pose.position = mujoco::vector(mujoco::entry<3>(data.site_xpos, arm_.tool));
  mjtNum turned[4];
  mju_mat2Quat(turned, mujoco::entry<9>(data.site_xmat, arm_.tool));
  state.pose.orientation = mujoco::quaternion(turned);
  mjtNum velocity[kWays];  // angular part first
  mj_objectVelocity(&model_, &data, mjOBJ_SITE, arm_.tool, velocity, 0);
  state.angular_velocity = mujoco::vector(velocity);
  state.velocity = mujoco::vector(velocity + kLinear);
  return state;
}

void Impedance::aim(const FollowerTarget& target, const ToolState& tool) noexcept {
  if (!target.pose.position.allFinite() || !is_orientation(target.pose.orientation)) return;
  const Vec3 way = target.pose.position - tool.pose.position;
  const Vec3 turn = rotation_between(tool.pose.orientation, target.pose.orientation);
  const double far = control_.largest_pull / control_.stiffness;
  const double wide = control_.largest_turn / control_.turning_stiffness;
  const Pose before = target_.pose;
  const double turned = length(turn);
  if (length(way) > far || turned > wide) {
    const Vec3 left = clamp_length(turn, wide);
    target_.pose.position = tool.pose.position + clamp_length(way, far);
    target_.pose.orientation =
        turned > wide ? Quaternion(Eigen::AngleAxisd(wide, left / wide)) * tool.pose.orientation
                      : target.pose.orientation.normalized();
    // The limited target moves with the tool, so its movement is not a commanded velocity.
    moved_.setZero();
  } else {
    target_.pose = {target.pose.position, target.pose.orientation.normalized()};
    moved_.head<3>() += target_.pose.position - before.position;
    moved_.tail<3>() += rotation_between(before.orientation, target_.pose.orientation);
  }
  if (std::isfinite(target.gripper) && arm_.fingers)
    target_.gripper = std::clamp(target.gripper, 0.0, 2.0 * arm_.fingers->front().high);
}

void Impedance::hold(const ToolState& tool) noexcept {
  target_.pose = tool.pose;
  moved_.setZero();
  pace_.setZero();
  reference_.setZero();
}

void Impedance::spread(int steps, bool touching) noexcept {
  if (steps <= 0) return;
  const double span = steps * model_.opt.timestep;
  pace_ = clamp_length(Vec6(moved_ / span), kFastest, kFastestTurn);
  if (touching) pace_.setZero();
  moved_.setZero();
}

/// Returns the axis torques [N m] that carry the weight of the arm.
Vec7 Impedance::gravity(const mjData& data) const noexcept {
  const Vec3 down = mujoco::vector(model_.opt.gravity);
  Vec7 torque;
  for (int i = 0; i < kAxes; ++i) {
    const int joint = arm_.axes.at(static_cast<std::size_t>(i)).joint;
    const int body = model_.jnt_bodyid[joint];
    const Vec3 lever = mujoco::vector(mujoco::entry<3>(data.subtree_com, body)) -
                       mujoco::vector(mujoco::entry<3>(data.xanchor, joint));
    torque[i] = -model_.body_subtreemass[body] *
                mujoco::vector(mujoco::entry<3>(data.xaxis, joint)).dot(lever.cross(down));
  }
  return torque;
}

Vec7 Impedance::walls(const Vec7& q, const Vec7& speed) const noexcept {
  Vec7 torque = Vec7::Zero();
  for (int i = 0; i < kAxes; ++i) {
    const Axis& axis = arm_.axes.at(static_cast<std::size_t>(i));
    const double below = axis.low + kBefore - q[i], above = q[i] - axis.high + kBefore;
    if (below > 0.0) torque[i] = kWall * below - kWallDamping * speed[i];
    if (above > 0.0) torque[i] = -kWall * above - kWallDamping * speed[i];
  }
  return torque;
}

/// Returns the joint torques that pull the arm towards its home posture, without the part that
/// would move the tool. The projection is Khatib's dynamically consistent null space (IEEE J.
/// Robotics and Automation 3(1) 1987).
Vec7 Impedance::posture(const Vec7& q, const Vec7& speed) noexcept {
  constexpr double kSingular = 1e-6;  // [1/kg] added to the mobility, so that its inverse is finite
  const std::ptrdiff_t speeds = model_.nv;
  const mjtNum* const rows = solved_.data();
  Jacobian solved;
  for (int i = 0; i < kAxes; ++i)
    for (int way = 0; way < kWays; ++way)
      solved(way, i) = rows[way * speeds + arm_.axes.at(static_cast<std::size_t>(i)).speed];
  const Vec7 drawn = control_.posture_stiffness * (arm_.home - q) - posture_damping_ * speed;
  const Mat6 mobility = jacobian_ * solved.transpose() + kSingular * Mat6::Identity();
  return drawn - jacobian_.transpose() * mobility.ldlt().solve(Vec6(solved * drawn));
}

void Impedance::drive(mjData& data) noexcept {
  find_jacobian(data);
  mj_solveM(&model_, &data, solved_.data(), rows_.data(), kWays);
  const ToolState now = tool(data);
  reference_ += share_ * (pace_ - reference_);
  Vec6 wrench, velocity;
  wrench << control_.stiffness * (target_.pose.position - now.pose.position),
      control_.turning_stiffness * rotation_between(now.pose.orientation, target_.pose.orientation);
  wrench = clamp_length(wrench, control_.largest_pull, control_.largest_turn);
  velocity << now.velocity, now.angular_velocity;
  wrench.head<3>() += damping_ * (reference_ - velocity).head<3>();
  wrench.tail<3>() += turning_damping_ * (reference_ - velocity).tail<3>();
  Vec7 q, speed;
  for (int i = 0; i < kAxes; ++i) {
    const Axis& axis = arm_.axes.at(static_cast<std::size_t>(i));
    q[i] = data.qpos[axis.position];
    speed[i] = data.qvel[axis.speed];
  }
  const Vec7 torque =
      jacobian_.transpose() * wrench + gravity(data) + walls(q, speed) + posture(q, speed);
  for (int i = 0; i < kAxes; ++i) {
    const Axis& axis = arm_.axes.at(static_cast<std::size_t>(i));
    data.ctrl[axis.motor] = std::clamp(torque[i], -axis.most, axis.most);
  }
  if (arm_.fingers) drive_gripper(data);
}

void Impedance::drive_gripper(mjData& data) noexcept {
  const auto& [a, b] = *arm_.fingers;
  const double middle = 0.5 * (data.qpos[a.position] + data.qpos[b.position]);
  const double speed = 0.5 * (data.qvel[a.speed] + data.qvel[b.speed]);
  const double apart = data.qpos[a.position] - data.qpos[b.position];
  const double parting = data.qvel[a.speed] - data.qvel[b.speed];
  const double most = std::min(a.most, b.most);
  const double both =
      std::clamp(kGrip * (0.5 * target_.gripper - middle) - kGripDamping * speed, -most, most);
  const double level = 0.5 * (kLevel * apart + kLevelDamping * parting);
  grip_ = std::max(0.0, -both);
  data.ctrl[a.motor] = std::clamp(both - level, -a.most, a.most);
  data.ctrl[b.motor] = std::clamp(both + level, -b.most, b.most);
}

double Impedance::energy(const mjData& data) const noexcept {
  const ToolState now = tool(data);
  double sum = stored(control_.stiffness, length(Vec3(target_.pose.position - now.pose.position)),
                      control_.largest_pull) +
               stored(control_.turning_stiffness,
                      length(rotation_between(now.pose.orientation, target_.pose.orientation)),
                      control_.largest_turn);
  for (int i = 0; i < kAxes; ++i) {
    const Axis& axis = arm_.axes.at(static_cast<std::size_t>(i));
    const double q = data.qpos[axis.position], away = arm_.home[i] - q;
    const double in = std::max({0.0, axis.low + kBefore - q, q - axis.high + kBefore});
    sum += 0.5 * (control_.posture_stiffness * away * away + kWall * in * in);
  }
  return sum;
}

}  // namespace feltwire::arm
