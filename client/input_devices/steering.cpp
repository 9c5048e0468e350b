#include "client/input_devices/steering.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "client/hands/hand_aim.hpp"
#include "client/input_devices/input_nodes.hpp"

namespace feltwire {
namespace {

using std::chrono::milliseconds;

// Longest silence of a moved 3D mouse, which reports every 8 to 16 ms.
constexpr Nanoseconds kRelativeSilence = milliseconds(100);
constexpr Nanoseconds kSilence = milliseconds(2000);
constexpr double kRelativeReach = 350.0;  // [counts] largest deflection of a 3Dconnexion axis
constexpr double kGripper = 0.08;         // [m] opening of the open gripper
constexpr double kLargestRest = 0.9;

void require_of_steering(bool good, const char* message) {
  if (!good) throw std::invalid_argument(message);
}

}  // namespace

void validate(const SteeringOptions& options) {
  require_of_steering(options.speed > 0.0 && options.speed <= 1.0,
                      "steer_speed of --device must be above 0 and at most 1 m/s; 0.1 is usual");
  require_of_steering(options.turn > 0.0 && options.turn <= 10.0,
                      "steer_turn of --device must be above 0 and at most 10 rad/s; 0.8 is usual");
  require_of_steering(options.dead_zone >= 0.0 && options.dead_zone <= 0.5,
                      "dead_zone of --device must be from 0 to 0.5 of an axis; 0.1 is usual");
}

InputState::InputState(const EventNode& node, std::string_view kind, const SteeringOptions& options)
    : options_(options) {
  validate(options);
  const std::string_view found = input_kind(node.keys(), node.axes(), node.relative_axes());
  if (found != kind)
    throw std::runtime_error(
        found.empty() ? "it is neither a gamepad nor a 3D mouse: no two axes with BTN_SOUTH, no "
                        "six axes with BTN_0; feltwire-client devices lists the existing ones"
                      : "it is a " + std::string(found) + "; use --device " + std::string(found));
  lay_out(node, kind, options.dead_zone);
  if (!read_all(node)) throw std::runtime_error("it was unplugged; plug it in anew");
}

InputState::Axis InputState::absolute(const EventNode& node, unsigned code, double sign,
                                      double dead_zone) const {
  const auto info = node.axis(code);
  if (!info || info->maximum <= info->minimum)
    throw std::runtime_error("the kernel knows no range of its axis " + std::to_string(code) +
                             "; plug it in anew, or calibrate it (evdev-joystick)");
  const double least = info->minimum, most = info->maximum, reach = 0.5 * (most - least);
  return {code, sign, 0.5 * (least + most), reach,
          std::clamp(info->flat / reach, dead_zone, kLargestRest)};
}

/// Assigns the device's axes to the directions of the hand. The kernel's axes x, y and z point
/// right, towards the person and down. The other axes are rotations about x, y and z.
void InputState::lay_out(const EventNode& node, std::string_view kind, double dead_zone) {
  const InputAxes has = node.axes();
  if (kind == "spacemouse") {
    enable_ = BTN_0;
    clutch_ = BTN_1;
    others_ = kMouseButtons;
    relative_ = !has[ABS_RZ];
    constexpr std::array<std::pair<unsigned, double>, kSix> kAxes = {
        {{ABS_Y, 1.0}, {ABS_X, 1.0}, {ABS_Z, -1.0}, {ABS_RY, 1.0}, {ABS_RX, 1.0}, {ABS_RZ, -1.0}}};
    for (std::size_t i = 0; i < kSix; ++i) {
      const auto [code, sign] = kAxes[i];  // EV_REL uses the same axis numbers as EV_ABS
      layout_[i] = relative_ ? Axis{code, sign, 0.0, kRelativeReach, dead_zone}
                             : absolute(node, code, sign, dead_zone);
    }
    return;
  }
  enable_ = BTN_TR;
  clutch_ = BTN_TL;
  others_ = kPadButtons;
  const bool usual = has[ABS_RX] && has[ABS_RY];  // false for gamepads without their own driver
  const auto put = [&](std::size_t place, unsigned code, double sign) {
    if (has[code]) layout_[place] = absolute(node, code, sign, dead_zone);
  };
  put(0, ABS_Y, 1.0);
  put(1, ABS_X, 1.0);
  put(2, usual ? ABS_RY : ABS_RZ, -1.0);
  put(3, ABS_HAT0X, -1.0);
  put(4, ABS_HAT0Y, 1.0);
  put(5, usual ? ABS_RX : ABS_Z, -1.0);
  lay_out_gripper(node, has, usual);
}

/// Finds the right trigger, which moves the gripper. Its code depends on the gamepad.
void InputState::lay_out_gripper(const EventNode& node, const InputAxes& has, bool usual) {
  if (has[ABS_HAT2X]) trigger_ = ABS_HAT2X;
  if (has[ABS_GAS]) trigger_ = ABS_GAS;
  if (has[ABS_RZ] && usual) trigger_ = ABS_RZ;
  if (!trigger_) return;
  const auto info = node.axis(*trigger_);
  if (!info || info->maximum <= info->minimum) return trigger_.reset();
  trigger_open_ = info->minimum;
  trigger_closed_ = info->maximum;
}

bool InputState::read_all(const EventNode& node) noexcept {
  const auto keys = node.pressed();
  if (!keys) return false;
  Values values;
  values.keys = *keys;
  if (!relative_) {
    const InputAxes has = node.axes();
    for (unsigned code = 0; code < ABS_CNT; ++code) {
      if (!has[code]) continue;
      const auto info = node.axis(code);
      if (!info) return false;
      values.axes[code] = info->value;
    }
  }
  values_ = coming_ = values;
  moved_ = {};
  return true;
}

bool InputState::take(const input_event& event, Nanoseconds now, const EventNode& node) noexcept {
  heard_ = now;
  if (event.type == EV_SYN && event.code == SYN_DROPPED) {
    dropped_ = true;
    return true;
  }
  if (event.type == EV_SYN && event.code == SYN_REPORT) {
    if (dropped_) {
      dropped_ = false;
      return read_all(node);
    }
    end_packet(now);
    return true;
  }
  if (dropped_) return true;
  if (event.type == EV_KEY && event.code < KEY_CNT) coming_.keys[event.code] = event.value != 0;
  if (event.type == EV_ABS && event.code < ABS_CNT && !relative_)
    coming_.axes[event.code] = event.value;
  if (event.type == EV_REL && event.code <= REL_RZ && relative_) {
    const std::size_t group = event.code < REL_RX ? 0 : 1;
    // A packet contains all three axes of a group, but the kernel omits zeros.
    if (!moved_[group]) std::fill_n(coming_.axes.begin() + (group == 0 ? REL_X : REL_RX), 3, 0);
    moved_[group] = true;
    coming_.axes[event.code] = event.value;
  }
  return true;
}

void InputState::end_packet(Nanoseconds now) noexcept {
  values_ = coming_;
  for (std::size_t group = 0; group < moved_.size(); ++group)
    if (moved_[group]) moved_at_[group] = now;
  moved_ = {};
}

/// Returns the deflection of an axis, from -1 to 1, and 0 near rest. The deflection is squared, so
/// that small deflections move the tool slowly.
double InputState::deflection(const Axis& axis, Nanoseconds now) const noexcept {
  if (axis.sign == 0.0) return 0.0;
  if (relative_ && now - moved_at_[axis.code < REL_RX ? 0 : 1] > kRelativeSilence) return 0.0;
  const double way = std::clamp((values_.axes[axis.code] - axis.middle) / axis.reach, -1.0, 1.0);
  const double beyond = std::max(0.0, (std::abs(way) - axis.rest) / (1.0 - axis.rest));
  return axis.sign * std::copysign(beyond * beyond, way);
}

Steering InputState::steering(Nanoseconds now) noexcept {
  if (!heard_) heard_ = now;
  Vec3 move, turn;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = static_cast<Eigen::Index>(i);
    move[place] = deflection(layout_[i], now);
    turn[place] = deflection(layout_[3 + i], now);
  }
  rested_ |= move.isZero(0.0) && turn.isZero(0.0);

  Steering told;
  told.enabled = values_.keys[enable_];
  told.clutched = values_.keys[clutch_];
  for (std::size_t i = 0; i < others_.size(); ++i)
    told.buttons |= static_cast<std::uint32_t>(values_.keys[others_[i]]) << i;
  if (trigger_) {
    const double closed =
        (values_.axes[*trigger_] - trigger_open_) / (trigger_closed_ - trigger_open_);
    told.gripper = kGripper * (1.0 - std::clamp(closed, 0.0, 1.0));
  }
  if (!rested_ || told.clutched || now - *heard_ > kSilence) return told;
  told.velocity = options_.speed * clamp_length(move, 1.0);
  told.turn = options_.turn * clamp_length(turn, 1.0);
  return told;
}

}  // namespace feltwire
