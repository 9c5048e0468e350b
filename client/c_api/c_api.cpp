// The functions of feltwire.h for a hand, and those of no handle.

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/c_api/c_call.hpp"
#include "client/c_api/c_values.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/hand_opening.hpp"
#include "client/c_api/result_texts.hpp"

namespace feltwire {
namespace {

constexpr std::uint32_t kMajor = 0, kMinor = 1, kPatch = 0;  // of CMakeLists.txt: a test compares

fw_hand_options usual_options() noexcept {
  fw_hand_options options{};
  options.struct_size = sizeof options;
  options.name = "libfeltwire";
  options.device = "simulated";
  options.stale_after = 0.02;
  return options;
}

fw_pose usual_pose() noexcept {
  fw_pose pose{};
  pose.struct_size = sizeof pose;
  pose.orientation[0] = 1.0;
  pose.gripper = -1.0;
  return pose;
}

/// Returns the words of feltwire-client that say where the scene is.
std::vector<std::string> place_of(const fw_hand_options& options) {
  if (options.server == nullptr) throw std::invalid_argument("hand_options.server is null");
  std::vector<std::string> words;
  const auto add = [&](const char* option, const char* value) {
    if (value != nullptr) words.insert(words.end(), {option, value});
  };
  add("--connect", options.server);
  add("--fingerprint", options.fingerprint);
  add("--fingerprint-file", options.fingerprint_file);
  add("--ca", options.ca_file);
  add("--token-file", options.token_file);
  add("--scene", options.scene);
  return words;
}

/// Throws std::invalid_argument if no hand can be there.
CallerDevice::Move to_move(const fw_pose& pose) {
  constexpr double kFarthest = 1e3;  // [m]
  const Vec3 position = vector(pose.position);
  const Quaternion turn = quaternion(pose.orientation);
  if (!(position.norm() < kFarthest))
    throw std::invalid_argument("pose.position is not a number, or farther than 1 km away");
  if (!(turn.norm() > 0.5 && turn.norm() < 2.0))
    throw std::invalid_argument("pose.orientation is no unit quaternion w, x, y, z");
  if (!std::isfinite(pose.gripper)) throw std::invalid_argument("pose.gripper is not a number");
  return {.pose = {position, turn.normalized()},
          .buttons = pose.buttons,
          .deadman = pose.deadman != 0,
          .gripper = pose.gripper};
}

/// Throws std::invalid_argument if the program is not the device of this hand, or not the one that
/// makes the ticks (`steps`), or is it.
void require_device(const OpenHand& hand, bool steps) {
  if (hand.caller() == nullptr)
    throw std::invalid_argument(steps ? "the hand's device is not \"stepped\": it moves itself"
                                      : "the hand's device is not \"caller\": it moves itself");
  if (hand.caller()->makes_ticks() == steps) return;
  throw std::invalid_argument(
      steps ? "the hand's device is \"caller\": call fw_hand_exchange(), or open it as \"stepped\""
            : "the hand's device is \"stepped\": call fw_hand_step(), or open it as \"caller\"");
}

}  // namespace
}  // namespace feltwire

using namespace feltwire;

std::uint32_t fw_version() { return kMajor << 16 | kMinor << 8 | kPatch; }

const char* fw_last_error() { return last_error(); }

const char* fw_result_text(std::int32_t result) { return result_text(result); }

const char* fw_zero_force_text(std::uint32_t reason) {
  // The texts are literals, so each ends in a zero byte.
  return reason < kZeroForceReasons ? text(static_cast<ZeroForceReason>(reason)).data() : "";
}

void fw_hand_options_default(fw_hand_options* options, std::uint32_t struct_size) {
  if (options != nullptr) write_struct(usual_options(), options, struct_size);
}

void fw_pose_default(fw_pose* pose, std::uint32_t struct_size) {
  if (pose != nullptr) write_struct(usual_pose(), pose, struct_size);
}

std::int32_t fw_hand_open(const fw_hand_options* options, fw_hand** hand) {
  return open_handle(hand, "hand", [&] {
    const fw_hand_options given = read_struct(options, usual_options(), "hand_options");
    return open_hand({"hand_options", place_of(given), given});
  });
}

std::int32_t fw_hand_session(const fw_hand* hand, fw_session* session, std::uint32_t struct_size) {
  if (!is_open(hand)) return not_open("hand");
  if (session == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "session is null, or struct_size is not its size");
  const control::JoinAccepted& accepted = hand->object->accepted();
  fw_session out{};
  out.number = accepted.session;
  out.servo_period = accepted.parameters.servo_period;
  out.hold_time = accepted.parameters.hold_time;
  out.stiffness = accepted.stiffness;
  put(accepted.start_position, out.start_position);
  put(accepted.start_normal, out.start_normal);
  write_struct(out, session, struct_size);
  return FW_OK;
}

std::int32_t fw_hand_exchange(fw_hand* hand, const fw_pose* pose, fw_tick* tick,
                              std::uint32_t struct_size) {
  if (!is_open(hand)) return not_open("hand");
  if (tick == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "tick is null, or struct_size is not its size");
  return guarded([&] {
    require_device(*hand->object, false);
    const CallerDevice::Move move = to_move(read_struct(pose, usual_pose(), "pose"));
    fw_tick newest{};
    const bool ticked = hand->object->exchange(move, newest);
    write_struct(newest, tick, struct_size);
    if (hand->object->over().is_set()) return FW_ENDED;
    return ticked ? FW_OK : FW_NOTHING;
  });
}

std::int32_t fw_hand_step(fw_hand* hand, const fw_pose* pose, fw_tick* tick,
                          std::uint32_t struct_size) {
  if (!is_open(hand)) return not_open("hand");
  if (tick == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "tick is null, or struct_size is not its size");
  return guarded([&] {
    require_device(*hand->object, true);
    const CallerDevice::Move move = to_move(read_struct(pose, usual_pose(), "pose"));
    fw_tick made{};
    const bool ticked = hand->object->step(move, made);
    write_struct(made, tick, struct_size);
    if (hand->object->over().is_set()) return FW_ENDED;
    return ticked ? FW_OK : FW_NOTHING;
  });
}

std::int32_t fw_hand_latest(const fw_hand* hand, fw_tick* tick, std::uint32_t struct_size) {
  if (!is_open(hand)) return not_open("hand");
  if (tick == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "tick is null, or struct_size is not its size");
  fw_tick newest{};
  if (!hand->object->latest(newest)) return FW_NOTHING;
  write_struct(newest, tick, struct_size);
  return FW_OK;
}

std::int32_t fw_hand_ticks(fw_hand* hand, fw_tick* ticks, std::uint32_t struct_size,
                           std::uint32_t most, std::uint32_t* count) {
  if (!is_open(hand)) return not_open("hand");
  if (ticks == nullptr || count == nullptr || !is_size(struct_size))
    return fail(FW_ERROR_ARGUMENT, "ticks or count is null, or struct_size is not the tick's size");
  auto* to = reinterpret_cast<unsigned char*>(ticks);
  fw_tick tick{};
  for (*count = 0; *count < most && hand->object->next(tick); ++*count)
    write_struct(tick, to + std::size_t{*count} * struct_size, struct_size);
  return *count > 0 ? FW_OK : FW_NOTHING;
}

std::int32_t fw_hand_message(fw_hand* hand, char* text, std::uint32_t size) {
  if (!is_open(hand)) return not_open("hand");
  return give_message(hand->object->messages(), text, size);
}

std::int32_t fw_hand_wait(fw_hand* hand, double timeout) {
  if (!is_open(hand)) return not_open("hand");
  return wait_for_end(hand->object->over(), timeout);
}

std::int32_t fw_hand_stop(fw_hand* hand) {
  if (!is_open(hand)) return not_open("hand");
  hand->object->stop();
  return FW_OK;
}

std::int32_t fw_hand_close(fw_hand* hand) {
  if (hand == nullptr) return FW_OK;
  if (!is_open(hand)) return not_open("hand");
  closes(hand->object.get());
  const std::string error = hand->object->end();
  const bool stuck = hand->object->is_stuck();
  if (stuck)
    // A thread still uses the run, so that it may not be freed.
    static_cast<void>(hand->object.release());
  delete hand;
  if (!error.empty()) return fail(FW_ENDED, error.c_str());
  return stuck ? fail(FW_ERROR_DEVICE, "a call of the device does not return") : FW_OK;
}
