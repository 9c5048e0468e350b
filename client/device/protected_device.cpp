#include "client/device/protected_device.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kTakeUp = 0.5;         // [s] time to take up or release the tool's weight
constexpr double kStillWithin = 0.003;  // [m] largest movement of a still hand
constexpr Nanoseconds kLongPause = std::chrono::milliseconds(20);
constexpr int kMostButtons = 32;
constexpr double kNoForceLeft = 1e-9;  // [N] largest rounding error of the mean of two equal forces
// Largest share of the device's continuous force that the weight of a tool may use.
constexpr double kMostOfForce = 0.8;

/// Throws std::invalid_argument unless the button number is valid. Zero means no button.
void require_number(const char* option, int button) {
  if (button < 0 || button > kMostButtons)
    throw std::invalid_argument(std::string(option) + " of --device must be from 1 to 32");
}

/// Returns whether the button is pressed. Buttons count from 1, and 0 means no button.
bool is_pressed(std::uint32_t buttons, int button) noexcept {
  return button > 0 && (buttons >> static_cast<unsigned>(button - 1) & 1U) != 0;
}

}  // namespace

DeviceSpec protected_spec(const DeviceSpec& device, const ProtectionOptions& options) {
  if (!(options.still >= 0.0) || !std::isfinite(options.still))
    throw std::invalid_argument("await_still of --device must be 0 or above [s]");
  require_number("emergency_button", options.emergency_button);
  require_number("deadman_button", options.deadman_button.value_or(0));
  require_number("clutch_button", options.clutch_button.value_or(0));
  DeviceSpec spec = device;
  const double weight = options.tool_weight;
  if (weight == 0.0) return spec;
  const double most = kMostOfForce * std::min(device.continuous_force, device.max_force);
  std::ostringstream why;
  if (!(weight > 0.0))
    why << "it must be above 0";
  else if (device.translation_dof < 3)
    why << "device '" << device.name << "' has no force along z; leave it out";
  else if (weight > most)
    why << weight << " N is more than 80 % of the " << most / kMostOfForce << " N that device '"
        << device.name << "' gives for long; take a lighter tool";
  if (!why.str().empty()) throw std::invalid_argument("tool_weight of --device: " + why.str());
  spec.max_force -= weight;
  spec.continuous_force -= weight;
  spec.hand_force += weight;
  return spec;
}

ProtectedDevice::ProtectedDevice(std::unique_ptr<Device> device, const ProtectionOptions& options,
                                 std::shared_ptr<EmergencyStop> emergency)
    : device_(std::move(device)),
      options_(options),
      emergency_(std::move(emergency)),
      spec_(protected_spec(device_->spec(), options)) {}

/// Returns whether the hand has been still for the required time. A pressed enabling switch also
/// suffices, because it proves that a person holds the device.
bool ProtectedDevice::still(const DeviceReading& reading, Nanoseconds now) noexcept {
  if (options_.still == 0.0 || reading.deadman) return true;
  if (!since_ || (reading.pose.position - still_at_).norm() > kStillWithin) {
    still_at_ = reading.pose.position;
    since_ = now;
  }
  return seconds(now - *since_) >= options_.still;
}

void ProtectedDevice::take_up(Nanoseconds now) noexcept {
  const double elapsed = std::clamp(seconds(now - changed_), 0.0, kTakeUp);
  share_ = options_.tool_weight > 0.0 ? std::min(1.0, share_ + elapsed / kTakeUp) : 1.0;
  if (share_ == 1.0) stage_ = Stage::open;
}

DeviceReading ProtectedDevice::read(Nanoseconds now) noexcept {
  DeviceReading reading = device_->read(now);
  if (reading.ok && is_pressed(reading.buttons, options_.emergency_button)) emergency_->press();
  if (options_.deadman_button)
    reading.deadman = is_pressed(reading.buttons, *options_.deadman_button);
  if (options_.clutch_button) reading.clutch = is_pressed(reading.buttons, *options_.clutch_button);
  if (reading.ok && emergency_->pressed()) {
    if (!reading.fresh) reading.pose = pose_;
    reading.fresh = true;  // so that this tick writes zero force
    reading.withheld = Withheld::emergency;
  }
  if (reading.fresh) pose_ = reading.pose;
  if (reading.held) reading.held = less_weight(*reading.held);
  if (!reading.ok || reading.withheld != Withheld::nothing) {
    // After a fault, only take up the weight again, because the hand may still hold the device.
    // Otherwise also wait until the hand is still.
    stage_ = reading.ok || stage_ == Stage::moving ? Stage::moving : Stage::rising;
    share_ = 0.0;
    since_.reset();
  } else if (stage_ == Stage::open && options_.tool_weight > 0.0 && !lowering_ &&
             now - changed_ > kLongPause) {
    // The device made no ticks for a long time and has released the weight, so take it up again.
    stage_ = Stage::rising;
    share_ = 0.0;
    reading.withheld = Withheld::starting;
  } else if (reading.fresh && !lowering_) {
    if (stage_ == Stage::moving && still(reading, now)) {
      stage_ = Stage::rising;
      changed_ = now;
    }
    if (stage_ == Stage::rising) take_up(now);
    if (stage_ != Stage::open) reading.withheld = Withheld::starting;
  }
  if (!lowering_) changed_ = now;
  return reading;
}

Command ProtectedDevice::less_weight(const Command& held) const noexcept {
  if (options_.tool_weight == 0.0) return held;
  Command rest = held;
  rest.elastic -= weight();
  if (length(rest.force()) <= kNoForceLeft && rest.torque.isZero(0.0)) return {};
  return rest;
}

Command ProtectedDevice::write(const Command& on_hand) noexcept {
  if (emergency_->pressed()) {
    share_ = 0.0;
    return device_->write({});
  }
  if (share_ == 0.0 || options_.tool_weight == 0.0) return device_->write(on_hand);
  Command all = on_hand;
  all.elastic += weight();
  const Command held = device_->write(all);
  return held == all ? on_hand : less_weight(held);
}

bool ProtectedDevice::lower_tool(Nanoseconds now) noexcept {
  if (!lowering_) {
    lowering_ = true;
    changed_ = now;
  }
  if (options_.tool_weight == 0.0) return true;
  share_ = std::max(0.0, share_ - std::clamp(seconds(now - changed_), 0.0, kTakeUp) / kTakeUp);
  changed_ = now;
  return share_ == 0.0;
}

}  // namespace feltwire
