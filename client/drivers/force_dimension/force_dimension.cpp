#include "client/drivers/force_dimension/force_dimension.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <utility>

#include "client/device/assumed_transmission.hpp"
#include "client/device/async_signal_release.hpp"
#include "client/device/connection_lag.hpp"
#include "client/device/held_command.hpp"
#include "client/drivers/force_dimension/force_dimension_library.hpp"
#include "core/device/spec_text.hpp"

namespace feltwire {
namespace drd {
namespace {

// Return values of the SDK besides 0 and -1 (error): old reading, limited force.
constexpr int kOld = 1, kSaturated = 2;
// Indices in dhdGetStatus(). The number of valid entries depends on the SDK.
constexpr std::size_t kConnected = 1, kForce = 5, kGravity = 10, kOffCause = 14, kStatuses = 32;
constexpr int kByWatchdog = 3;  // value of status[kOffCause] if the watchdog acted
constexpr int kNoDevice = 5;    // value of dhdErrorGetLast()
// Time of the watchdog, 80 x 125 us = 10 ms. The force ends this long after the last call.
constexpr unsigned char kWatchdog = 80;
constexpr int kOldest = 3;  // oldest supported SDK version

/// Adds torque to the specification of a device that reports wrist motors, with the values of the
/// sigma.7. The inertia stays unknown.
void add_torque(SourcedSpec& described) {
  const SourcedSpec sigma = sourced_spec("sigma.7");
  DeviceSpec& spec = described.spec;
  spec.rotation_actuated = sigma.spec.rotation_actuated;
  spec.rotational_damping = sigma.spec.rotational_damping;
  spec.max_torque = sigma.spec.max_torque;
  spec.rotation.resolution = sigma.spec.rotation.resolution;
  described.sources["rotation_actuated"] = "the device";
  for (const char* field : {"rotational_damping", "max_torque", "rotational_resolution"})
    described.sources[field] = "assumption: as the sigma.7";
}

/// Returns the specification of the model `name`. `wrist`: the device senses rotation. `torque`:
/// the wrist has motors.
SourcedSpec model(const std::string& name, bool wrist, bool torque) {
  constexpr std::pair<const char*, const char*> kFiles[] = {
      {"omega", "omega.7"},   {"delta", "delta.3"},
      {"lambda", "lambda.7"}, {"sigma", "lambda.7"},  // a sigma without wrist motors
      {"Falcon", "falcon"},   {"falcon", "falcon"}};
  const char* file = nullptr;
  for (const auto& [part, one] : kFiles)
    if (file == nullptr && name.find(part) != std::string::npos) file = one;
  if (torque && name.starts_with("sigma")) file = "sigma.7";
  SourcedSpec described = sourced_spec(file != nullptr ? file : "lambda.7");
  DeviceSpec& spec = described.spec;
  spec.name = name;
  spec.actuation.late_ticks = 0;  // only the driver in falcon.cpp applies forces one tick late
  described.sources.erase("late_ticks");
  spec.rotation_sensed = wrist ? 3 : 0;
  described.sources["rotation_sensed"] = "the device";
  if (torque && spec.rotation_actuated == 0) add_torque(described);
  if (file != nullptr) return described;
  constexpr double kSmallest = 5.0;  // [N] assumed largest force of an unknown model
  spec.max_force = spec.continuous_force = kSmallest;
  described.sources["max_force"] = "assumption: a model that is not known here";
  return described;
}

/// Returns how a model is connected. A Falcon uses full-speed USB. The others use high-speed USB or
/// a card that is at least as fast.
const Connection& connection_of(const std::string& model) {
  const bool falcon = model.find("alcon") != std::string::npos;
  return falcon ? kFullSpeedUsbConnection : kUsbConnection;
}

char device_number(const std::string& name) {
  int number = 0;
  const auto end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data(), end, number);
  const bool whole = name.empty() || (parsed.ec == std::errc() && parsed.ptr == end);
  constexpr int kMost = 15;
  if (!whole || number < 0 || number > kMost)
    refuse("'" + name + "' is no number of a device; give 0 to 15, or nothing for the first");
  return static_cast<char>(number);
}

/// Returns why the force is off, and the remedy.
const char* force_is_off(int cause) noexcept {
  switch (cause) {
    case 1:
      return "the device's force button is off; press it";
    case 2:
      return "the device switched its force off, because it moved too fast; press its force button";
    case kByWatchdog:
      return "the device's watchdog switched its force off";
    case 4:
      return "a program switched the device's force off; end other programs that use it";
    case 5:
      return "the device switched its force off, because USB failed; plug it in without a hub";
    case 6:
      return "the device's deadman switch is open; close it";
    default:
      return "the device's force is off; press its force button";
  }
}

class ForceDimensionDevice final : public Device {
 public:
  ForceDimensionDevice(SharedLibrary library, const DeviceRequest& request)
      : library_(std::move(library)), call_(library_) {
    int major = 0, minor = 0, release = 0, revision = 0;
    call_.version(&major, &minor, &release, &revision);
    if (major < kOldest)
      refuse(library_.file().string() + " is version " + std::to_string(major) + "." +
             std::to_string(minor) + " of the SDK; install 3.14 or newer");
    const int opened = call_.open(device_number(request.name));
    if (opened < 0) refuse("the device cannot be opened: " + last_error());
    id_ = static_cast<char>(opened);
    try {
      set_up(request);
    } catch (...) {
      call_.close(id_);
      throw;
    }
  }
  ~ForceDimensionDevice() override {
    constexpr int kTries = 10;
    let_go_.reset();  // its thread also calls the library
    give({});
    for (int n = 0; n < kTries && call_.stop(id_) < 0; ++n) continue;
    call_.close(id_);
  }
  ForceDimensionDevice(const ForceDimensionDevice&) = delete;
  ForceDimensionDevice& operator=(const ForceDimensionDevice&) = delete;

  const DeviceSpec& spec() const override { return described_.spec; }
  std::vector<std::string> notes() const { return notes_; }

  std::string_view prepare() noexcept override {
    Status status{};
    if (give({}) < 0 || call_.status(status.data(), id_) < 0 || status[kConnected] == 0)
      return "the device does not answer; see its cable and its power";
    if (status[kForce] != 0) return {};
    call_.enable_force(1, id_);
    if (call_.status(status.data(), id_) >= 0 && status[kForce] != 0) return {};
    return force_is_off(status[kOffCause]);
  }

  DeviceReading read(Nanoseconds) noexcept override {
    DeviceReading reading;
    double x = 0.0, y = 0.0, z = 0.0;
    double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // columns are the tool's axes
    const int answer =
        wrist_ ? call_.frame(&x, &y, &z, axes, id_) : call_.position(&x, &y, &z, id_);
    reading.ok = answer >= 0 && !lost_;
    if (answer == kOld && reading.ok) {
      // Write a force even without a new reading, because each write restarts the firmware's
      // watchdog.
      lost_ = give(on_hand_) < 0;
      reading.ok = !lost_;
      reading.fresh = false;
      return reading;
    }
    reading.pose.position = {x, y, z};
    const unsigned pressed = call_.buttons != nullptr ? call_.buttons(id_) : 0;
    reading.buttons = pressed;
    reading.clutch = (pressed & 1U) != 0;  // button 1, because most models have only one button
    reading.deadman = (pressed & 2U) != 0;
    if (wrist_) {
      Mat3 turn;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) turn(i, j) = axes[i][j];
      reading.pose.orientation = Quaternion(turn);
    }
    double gap = 0.0;
    if (gripper_ && call_.gripper_gap(&gap, id_) >= 0) reading.gripper = gap;
    return reading;
  }

  Command write(const Command& on_hand) noexcept override {
    on_hand_ = {};
    if (let_go_->asked()) return {};
    const bool nothing = on_hand.force().isZero(0.0) && on_hand.torque.isZero(0.0);
    const int answer = give(on_hand);
    // A failed call leaves the force on the hand unknown. Report failed readings until a write of
    // zero force has succeeded.
    lost_ = answer < 0 || (lost_ && !nothing);
    if (lost_) return {};
    Status status{};
    if (call_.status(status.data(), id_) < 0 || status[kConnected] == 0) lost_ = true;
    // Gravity compensation was switched on or off. The handle's weight can then do work over a
    // closed path, so treat this as a failed call.
    if (!lost_ && (status[kGravity] != 0) != compensates_) {
      compensates_ = !compensates_;
      lost_ = true;
    }
    if (lost_) return {};
    if (status[kForce] == 0) {  // the force button or the speed limit switched the force off
      // The watchdog acted during a pause of this program. Write zero force first, then switch the
      // amplifiers on.
      if (status[kOffCause] == kByWatchdog && give({}) >= 0) call_.enable_force(1, id_);
      return {};
    }
    on_hand_ = on_hand;
    if (answer != kSaturated || nothing) return on_hand;
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    if (!given(force, torque)) {
      lost_ = true;
      return {};
    }
    // Saturated motors shorten the force but keep its direction. Use only the part of the reported
    // force along the command, because the report may contain other forces too.
    const Vec3 asked = on_hand.force();
    return held_command(on_hand, held_share(force, asked) * asked,
                        held_share(torque, on_hand.torque) * on_hand.torque);
  }

  void release() noexcept override { let_go_->now(); }

 private:
  using Status = std::array<int, kStatuses>;

  /// Writes the command to the device. A gripper motor gets no force. Returns the result of the
  /// library call.
  int give(const Command& command) const noexcept {
    const Vec3 f = command.force(), &t = command.torque;
    return torque_ ? call_.set_wrench(f.x(), f.y(), f.z(), t.x(), t.y(), t.z(), 0.0, id_)
                   : call_.set_force(f.x(), f.y(), f.z(), id_);
  }

  /// Reads the force and torque of the motors [N, N m]. Returns false if the values are unknown.
  bool given(Vec3& force, Vec3& torque) const noexcept {
    double grip = 0.0;
    const int answer = torque_ ? call_.get_wrench(&force.x(), &force.y(), &force.z(), &torque.x(),
                                                  &torque.y(), &torque.z(), &grip, id_)
                               : call_.get_force(&force.x(), &force.y(), &force.z(), id_);
    return answer >= 0 && force.allFinite() && torque.allFinite();
  }

  std::string last_error() const {
    const int code = call_.error();
    const char* text = call_.error_text();
    std::string said =
        std::string(text != nullptr ? text : "no reason") + " (error " + std::to_string(code) + ")";
    if (code == kNoDevice)
      said +=
          "; switch it on and plug it in. If lsusb shows 1451: or 0403:cb48, give yourself the "
          "right to it: a file in /etc/udev/rules.d with SUBSYSTEM==\"usb\", "
          "ATTRS{idVendor}==\"1451\", TAG+=\"uaccess\"";
    return said;
  }

  void set_up(const DeviceRequest& request) {
    const char* told = call_.system_name(id_);
    const std::string name = told != nullptr && *told != '\0' ? told : "unknown";
    wrist_ = call_.has_wrist(id_);
    const bool actuated = wrist_ && call_.has_active_wrist != nullptr &&
                          call_.set_wrench != nullptr && call_.get_wrench != nullptr &&
                          call_.max_torque != nullptr && call_.has_active_wrist(id_);
    SourcedSpec found = model(name, wrist_, actuated);
    described_ = request.spec.name_or_file.empty() ? overruled(std::move(found), request.spec)
                                                   : requested_spec(request.spec, "");
    assume_lag(described_, connection_of(name));
    assume_transmission(described_, kCableDrive);
    DeviceSpec& spec = described_.spec;
    wrist_ = wrist_ && spec.rotation_sensed > 0;
    torque_ = wrist_ && actuated && spec.rotation_actuated > 0;
    if (!torque_) {
      spec.rotation_actuated = 0;
      spec.max_torque = 0.0;
    }
    gripper_ =
        call_.has_gripper != nullptr && call_.gripper_gap != nullptr && call_.has_gripper(id_);
    notes_ = assumptions(described_);
    if (call_.initialized == nullptr)
      notes_.emplace_back("libdhd cannot tell whether the device is calibrated; libdrd can");
    else if (!call_.initialized(id_))
      refuse(
          "the device is not calibrated; run the maker's HapticInit first (the arm moves by "
          "itself, hands off)");
    begin_watchdog();
    // Write zero force before the amplifiers are on, so that the start causes no kick.
    const bool ready = call_.max_force(spec.max_force, id_) >= 0 &&
                       (!torque_ || call_.max_torque(spec.max_torque, id_) >= 0) &&
                       call_.brakes(0, id_) >= 0 && give({}) >= 0 &&
                       call_.enable_force(1, id_) >= 0 && call_.gravity(1, id_) >= 0;
    if (!ready) refuse("the device cannot be made ready: " + last_error());
    Status status{};
    compensates_ = call_.status(status.data(), id_) >= 0 && status[kGravity] != 0;
    if (call_.left_handed != nullptr && call_.left_handed(id_))
      notes_.emplace_back(
          "it is a left-handed model: its axes are taken to be those of a right-handed one. See "
          "with a small --max-force that the tool follows the hand");
    notes_.emplace_back(
        compensates_
            ? "gravity compensation is on: the maker's library holds the handle's weight, and that "
              "force is not accounted"
            : "gravity compensation is off, although it was asked for: the handle pulls down. "
              "hand_force of the specification must have its weight in it");
    let_go_ = std::make_unique<AsyncSignalRelease>([this] { give({}); });
  }

  /// Starts the device's watchdog, which ends the force if the program crashes or the machine
  /// stops.
  void begin_watchdog() {
    unsigned char set = 0;
    const bool there = call_.expert_on != nullptr && call_.expert_off != nullptr &&
                       call_.set_watchdog != nullptr && call_.get_watchdog != nullptr;
    if (there && call_.expert_on() >= 0) {
      if (call_.set_watchdog(kWatchdog, id_) < 0 || call_.get_watchdog(&set, id_) < 0) set = 0;
      call_.expert_off();
    }
    if (set != kWatchdog)
      notes_.emplace_back(
          "the device's own watchdog could not be set: a program that is killed leaves its last "
          "force on the hand");
  }

  SharedLibrary library_;
  Calls call_;
  char id_ = 0;
  bool wrist_ = false;
  bool torque_ = false;  // whether the session uses wrist motors
  bool gripper_ = false;
  bool compensates_ = false;  // whether gravity compensation is on
  bool lost_ = false;         // whether a failed call left the force on the hand unknown
  SourcedSpec described_;
  std::vector<std::string> notes_;
  Command on_hand_;
  std::unique_ptr<AsyncSignalRelease> let_go_;
};

}  // namespace
}  // namespace drd

OpenedDevice open_force_dimension(const DeviceRequest& request) {
  auto device = std::make_unique<drd::ForceDimensionDevice>(drd::load(), request);
  std::vector<std::string> notes = device->notes();
  return {std::move(device), std::move(notes)};
}

std::string force_dimension_library() {
  const SharedLibrary library = drd::load();  // load() throws if a function is missing
  int major = 0, minor = 0, release = 0, revision = 0;
  library.get<void(int*, int*, int*, int*)>("dhdGetSDKVersion")(&major, &minor, &release,
                                                                &revision);
  return library.loaded_from().string() + ", version " + std::to_string(major) + "." +
         std::to_string(minor) + "." + std::to_string(release);
}

}  // namespace feltwire
