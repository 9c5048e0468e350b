#pragma once
// A handle with known true motion, behind a mapping, at a wall of the scene.

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <memory>
#include <random>
#include <utility>

#include "client/device/mapped_device.hpp"
#include "client/device/protected_device.hpp"
#include "client/servo/servo.hpp"
#include "core/base/numeric.hpp"
#include "tests/devices/simulated_mass.hpp"
#include "tests/devices/tick.hpp"

namespace feltwire::testing {

inline Vec3 vec(const stand_in::Three& v) { return {v[0], v[1], v[2]}; }

/// A handle with a simulated mass in a tapping hand. It applies a force at once or some ticks late,
/// and reports that number unless `tells` is false.
class Handle final : public Device {
 public:
  explicit Handle(std::size_t lag_ticks = 0, bool tells = true) : lag(lag_ticks) {
    spec_.actuation.late_ticks = tells ? static_cast<int>(lag) : 0;
    spec_.name = "handle";
    spec_.damping = mass.damping;
    spec_.apparent_mass = spec_.least_mass = mass.mass;
    spec_.coulomb_friction = spec_.least_friction = mass.friction;
    spec_.position_resolution = mass.quantum;
    spec_.max_force = spec_.continuous_force = 8.0;
    spec_.workspace = Vec3::Constant(0.1);
  }
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override {
    const Vec3 f = on_hand.force();
    mass.advance(kTick, {f.x(), f.y(), f.z()});
    if (lag > 0 && coming_.size() >= lag) {
      on_hand = coming_.front();
      coming_.pop_front();
    }
    DeviceReading reading;
    reading.pose.position = vec(mass.sensed());
    reading.pose.orientation = orientation;
    reading.clutch = clutch;
    reading.deadman = deadman;
    reading.buttons = buttons;
    reading.withheld = withheld;
    reading.ok = ok;
    reading.jumped = false;  // tests turn the handle faster than a hand
    return reading;
  }
  Command write(const Command& command) noexcept override {
    Command held = command;
    const double size = held.force().norm();
    if (size > spec_.max_force) held = (spec_.max_force / size) * held;
    if (released) held = {};
    if (lag == 0) return on_hand = held;
    coming_.push_back(held);
    return tells_held ? on_hand : held;
  }
  void release() noexcept override { released = true; }

  stand_in::SimulatedMass mass;
  Quaternion orientation = Quaternion::Identity();
  std::size_t lag;         // ticks
  bool tells_held = true;  // write() returns the force on the hand, else its argument
  bool clutch = false, deadman = false, ok = true, released = false;
  std::uint32_t buttons = 0;
  Withheld withheld = Withheld::nothing;
  Command on_hand;

 private:
  DeviceSpec spec_;
  std::deque<Command> coming_;
};

/// A mapped handle in a session at a wall that its taps reach.
struct Mapped {
  explicit Mapped(const WorkspaceMapping& mapping, std::string_view mode = kSessionMethod,
                  bool told_wrong = false, std::size_t lag = 0, bool tells_lag = true,
                  const ProtectionOptions& protection = {})
      : handle(new Handle(lag, tells_lag)),
        device(std::make_unique<ProtectedDevice>(std::unique_ptr<Device>(handle), protection,
                                                 emergency),
               mapping),
        servo(told_wrong ? handle->spec() : device.spec(), in_mode(mode),
              protect_hand(in_mode(mode))),
        normal(mapping.axes().col(2)),
        base(mapping.translation),
        // The handle feels an equal stiffness at any scale.
        stiffness(2000.0 / (mapping.scale * mapping.scale)) {}

  static SessionParameters in_mode(std::string_view mode) {
    SessionParameters parameters;
    parameters.mode = mode;
    return parameters;
  }

  void tick() {
    now += from_seconds(kTick);
    const Sample* sample = servo.tick(device, now);
    if (sample != nullptr) {
      Reply& reply = on_the_way.emplace_back();
      reply.sample_index = sample->index;
      reply.client_time = sample->client_time;
      tool = sample->pose;
      const double depth = normal.dot(base - sample->pose.position);
      reply.command.elastic = stiffness * std::max(0.0, depth) * normal;
    }
    if (on_the_way.size() <= 20) return;
    servo.take(on_the_way.front(), now);
    on_the_way.pop_front();
  }
  void run(double time) {
    for (long left = std::lround(time / kTick); left > 0; --left) tick();
  }
  /// Ticks until the handle gets this force [N].
  void feel(double force) {
    for (int n = 0; n < 5000 && handle->on_hand.force().norm() < force; ++n) tick();
    ASSERT_GE(handle->on_hand.force().norm(), force);
  }

  std::shared_ptr<EmergencyStop> emergency = std::make_shared<EmergencyStop>();
  Handle* handle;
  MappedDevice device;
  Servo servo;
  Vec3 normal, base;
  double stiffness;
  Pose tool;
  Nanoseconds now = std::chrono::seconds(7);
  std::deque<Reply> on_the_way;
};

inline WorkspaceMapping any_mapping(std::mt19937& random) {
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  const auto vector = [&] { return Vec3(part(random), part(random), part(random)); };
  WorkspaceMapping mapping;
  mapping.scale = std::pow(10.0, part(random));
  mapping.rotation = 1.8 * vector();
  mapping.translation = vector();
  if (part(random) > 0.0) mapping.mirrored_axis = static_cast<int>(random() % 3);
  return mapping;
}

}  // namespace feltwire::testing
