#include "client/drivers/joystick/joystick_device.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "client/hands/hand_aim.hpp"
#include "client/input_devices/input_nodes.hpp"
#include "core/device/spec_text.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

constexpr double kYieldingTurn = 1.25;  // [rad/s] the speed kYielding at a lever of 40 mm
constexpr double kLongest = 0.05;  // [s] longest time for which a deflection counts per reading
constexpr int kReadsATick = 4;     // reads per tick: 256 events, four times the usual number

OpenedDevice open_steered(std::string_view kind, const DeviceRequest& request) {
  const fs::path node = input_node(Machine{}, kind, request.name);
  SourcedSpec described = requested_spec(request.spec, "simulated_6dof");
  std::vector<std::string> notes = assumptions(described);
  notes.push_back("a " + std::string(kind) +
                  " gives no force: a surface holds the tool back, and the hand feels nothing");
  EventNode events(node);
  try {
    return {std::make_unique<JoystickDevice>(
                std::move(events), kind,
                JoystickHandOptions{
                    .spec = std::move(described.spec), .hand = {}, .steering = request.steering}),
            std::move(notes)};
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(node.string() + ": " + error.what());
  }
}

}  // namespace

JoystickDevice::JoystickDevice(EventNode node, std::string_view kind,
                               const JoystickHandOptions& options)
    : HandDevice(options.spec, options.hand),
      node_(std::move(node)),
      options_(options),
      input_(node_, kind, options.steering) {
  const auto usable = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (!usable(options.reach) || !usable(options.wrist_reach) || !usable(options.clearance))
    throw std::invalid_argument("the reaches of a steered hand must be finite and above zero");
}

void JoystickDevice::begin(const Vec3& position, const Vec3& normal) {
  aim_ = position + options_.clearance * normal.normalized();
  place(aim_);
}

void JoystickDevice::take_events(Nanoseconds now) noexcept {
  std::array<input_event, 64> room{};
  for (int round = 0; round < kReadsATick && !gone_; ++round) {
    const auto count = node_.read(room);
    gone_ = !count;
    for (std::size_t n = 0; !gone_ && n < *count; ++n) gone_ = !input_.take(room[n], now, node_);
    if (gone_ || *count < room.size()) return;
  }
}

DeviceReading JoystickDevice::read(Nanoseconds now) noexcept {
  if (!gone_) take_events(now);
  steering_ = gone_ ? Steering{} : input_.steering(now);
  DeviceReading reading = HandDevice::read(now);
  reading.ok = !gone_;
  reading.deadman = steering_.enabled;
  reading.gripper = steering_.gripper;
  reading.buttons = steering_.buttons;
  return reading;
}

Vec3 JoystickDevice::intended(double time) noexcept {
  const double elapsed = std::min(time - std::exchange(moved_until_, time), kLongest);
  const Vec3& hand = true_position();
  aim_ = hand + led(aim_ - hand, elapsed * steering_.velocity, options_.reach, kYielding * elapsed);
  return aim_;
}

Vec3 JoystickDevice::intended_turn(double time) noexcept {
  const double elapsed = std::min(time - std::exchange(turned_until_, time), kLongest);
  const Quaternion& hand = true_orientation();
  const Vec3 lead = rotation_between(hand, turned(turned_aim_, elapsed * steering_.turn));
  const Vec3 before = rotation_between(hand, turned_aim_);
  turned_aim_ = turned(hand, clamp_length(lead, std::max(options_.wrist_reach,
                                                         before.norm() - kYieldingTurn * elapsed)));
  return rotation_between(Quaternion::Identity(), turned_aim_);
}

fs::path input_node(const Machine& machine, std::string_view kind, const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  if (!name.empty()) return fs::path("/dev/input") / name;
  std::vector<InputNode> found = input_nodes(machine);
  std::erase_if(found, [&](const InputNode& node) { return node.kind != kind; });
  if (found.size() == 1) return found.front().node;
  if (found.empty())
    throw std::runtime_error("no " + std::string(kind) +
                             " is plugged in, by /sys/class/input; name its event node, as " +
                             std::string(kind) + ":event5");
  std::string list;
  for (const InputNode& node : found)
    list.append(list.empty() ? "" : ", ")
        .append(std::string(kind) + ":" + node.node.filename().string() + " (" + node.name + ")");
  throw std::runtime_error("there are several; name one: " + list);
}

OpenedDevice open_gamepad(const DeviceRequest& request) { return open_steered("gamepad", request); }

OpenedDevice open_spacemouse(const DeviceRequest& request) {
  return open_steered("spacemouse", request);
}

}  // namespace feltwire
