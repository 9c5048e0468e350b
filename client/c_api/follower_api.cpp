// The functions of feltwire.h for a robot that follows.

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "client/c_api/c_call.hpp"
#include "client/c_api/c_values.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/open_follower.hpp"
#include "protocol/net/clock.hpp"

/// The handle of a program.
struct fw_follower : feltwire::Owned<feltwire::OpenFollower> {};

namespace feltwire {
namespace {

constexpr std::uint32_t kLocks = 4;  // x, y, z, rotation

fw_follower_options usual_follower() noexcept {
  const FollowerSpec robot;
  const FollowerOptions limits;
  fw_follower_options options{};
  options.struct_size = sizeof options;
  options.name = "libfeltwire";
  options.robot = "robot";
  options.period = robot.servo_period;
  options.speed = limits.motion.speed;
  options.acceleration = limits.motion.acceleration;
  options.jerk = limits.motion.jerk;
  options.leash = limits.leash;
  options.patience = FollowerRun{}.patience;
  return options;
}

fw_robot_state usual_state() noexcept {
  fw_robot_state state{};
  state.struct_size = sizeof state;
  state.orientation[0] = state.commanded_orientation[0] = 1.0;
  return state;
}

void require_field(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("follower_options.") + what);
}

FollowerSpec robot_of(const fw_follower_options& options) {
  constexpr double kShortest = 1e-4, kLongest = 0.05;  // [s]
  const auto is_positive = [](double value) { return value >= 0.0 && std::isfinite(value); };
  require_field(options.robot != nullptr && *options.robot != '\0', "robot is null or empty");
  require_field(options.period >= kShortest && options.period <= kLongest,
                "period must be from 0.0001 to 0.05 s");
  require_field(options.stiffness > 0.0 && std::isfinite(options.stiffness),
                "stiffness must be above 0 N/m: that of the robot's own controller");
  require_field(is_positive(options.damping) && is_positive(options.own_damping),
                "damping and own_damping must be 0 N s/m or more");
  require_field(is_positive(options.mass), "mass must be 0 kg or more");
  require_field(is_positive(options.wrench_noise), "wrench_noise must be 0 N or more");
  require_field(is_positive(options.gripper_opening), "gripper_opening must be 0 m or more");
  require_field(is_positive(options.leash) && options.leash > 0.0, "leash must be above 0 N");
  return {.name = text_of(options.robot, "follower_options.robot"),
          .servo_period = options.period,
          .stiffness = options.stiffness,
          .damping = options.damping,
          .own_damping = options.own_damping,
          .mass = options.mass,
          .senses_wrench = options.estimates_force == 0,
          .wrench_noise = options.wrench_noise,
          .gripper_opening = options.gripper_opening};
}

Workspace workspace_of(const fw_follower_options& options) {
  Workspace workspace;
  const Vec3 low = vector(options.workspace_low), high = vector(options.workspace_high);
  if (!low.isZero(0.0) || !high.isZero(0.0)) {
    require_field(low.cwiseAbs().maxCoeff() <= Workspace::kFarthest &&
                      high.cwiseAbs().maxCoeff() <= Workspace::kFarthest &&
                      (low.array() < high.array()).all(),
                  "workspace_low must be below workspace_high on each axis, both within 1000 m");
    workspace.add_box(low, high);
  }
  require_field(options.locked < 1u << kLocks, "locked has bits for x, y, z and rotation only");
  for (std::size_t axis = 0; axis < workspace.locked.size(); ++axis)
    workspace.locked[axis] = (options.locked >> axis & 1u) != 0;
  workspace.turning_locked = (options.locked >> (kLocks - 1) & 1u) != 0;
  return workspace;
}

FollowerRun run_of(const fw_follower_options& options) {
  constexpr double kLongest = 1e6;  // [s]
  require_field(options.scene != nullptr, "scene is null");
  require_field(options.duration >= 0.0 && options.duration <= kLongest,
                "duration must be from 0 to 1e6 s");
  require_field(options.patience >= 0.0 && options.patience <= kLongest,
                "patience must be from 0 to 1e6 s");
  FollowerRun run;
  run.server = access_of(options, "follower_options");
  run.name = text_of(options.name, "follower_options.name");
  run.scene = text_of(options.scene, "follower_options.scene");
  run.seat = text_of(options.seat, "follower_options.seat");
  run.options.motion.speed = options.speed;
  run.options.motion.acceleration = options.acceleration;
  run.options.motion.jerk = options.jerk;
  run.options.leash = options.leash;
  run.options.workspace = workspace_of(options);
  run.duration = options.duration;
  run.patience = options.patience;
  return run;
}

/// Writes the newest target.
std::int32_t give_target(const OpenFollower& follower, fw_robot_target* target,
                         std::uint32_t struct_size) noexcept {
  fw_robot_target newest{};
  const bool is_there = follower.latest(newest);
  write_struct(newest, target, struct_size);
  return is_there ? FW_OK : FW_NOTHING;
}

}  // namespace
}  // namespace feltwire

using namespace feltwire;

const char* fw_lead_state_text(std::uint32_t state) {
  // The names are literals, so each ends in a zero byte.
  return state <= static_cast<std::uint32_t>(kLastLinkState)
             ? name(static_cast<LinkState>(state)).data()
             : "";
}

void fw_follower_options_default(fw_follower_options* options, std::uint32_t struct_size) {
  if (options != nullptr) write_struct(usual_follower(), options, struct_size);
}

void fw_robot_state_default(fw_robot_state* state, std::uint32_t struct_size) {
  if (state != nullptr) write_struct(usual_state(), state, struct_size);
}

std::int32_t fw_follower_open(const fw_follower_options* options, fw_follower** follower) {
  return open_handle(follower, "follower", [&] {
    const auto given = read_struct(options, usual_follower(), "follower_options");
    return std::make_unique<OpenFollower>(robot_of(given), run_of(given));
  });
}

std::int32_t fw_follower_exchange(fw_follower* follower, const fw_robot_state* state,
                                  fw_robot_target* target, std::uint32_t struct_size) {
  if (!is_open(follower)) return not_open("follower");
  if (target == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "target is null, or struct_size is not its size");
  return guarded([&] {
    follower->object->robot().report(read_struct(state, usual_state(), "robot_state"),
                                     monotonic_now());
    const bool is_over = follower->object->over().is_set();
    const std::int32_t result = give_target(*follower->object, target, struct_size);
    return is_over ? FW_ENDED : result;
  });
}

std::int32_t fw_follower_latest(const fw_follower* follower, fw_robot_target* target,
                                std::uint32_t struct_size) {
  if (!is_open(follower)) return not_open("follower");
  if (target == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "target is null, or struct_size is not its size");
  return give_target(*follower->object, target, struct_size);
}

std::int32_t fw_follower_message(fw_follower* follower, char* text, std::uint32_t size) {
  if (!is_open(follower)) return not_open("follower");
  return give_message(follower->object->messages(), text, size);
}

std::int32_t fw_follower_wait(fw_follower* follower, double timeout) {
  if (!is_open(follower)) return not_open("follower");
  return wait_for_end(follower->object->over(), timeout);
}

std::int32_t fw_follower_stop(fw_follower* follower) {
  if (!is_open(follower)) return not_open("follower");
  follower->object->stop();
  return FW_OK;
}

std::int32_t fw_follower_close(fw_follower* follower) {
  if (follower == nullptr) return FW_OK;
  if (!is_open(follower)) return not_open("follower");
  closes(follower->object.get());
  const std::string error = follower->object->end();
  delete follower;
  return error.empty() ? FW_OK : fail(FW_ENDED, error.c_str());
}
