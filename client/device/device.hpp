#pragma once
// The interface of a haptic device. Implement it to attach one (docs/devices.md).

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/base/types.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Why a device takes no force for now, although it has no fault.
enum class Withheld : std::uint8_t {
  nothing,     // it takes forces
  not_homed,   // its encoders have not found their zero: the pose means nothing
  in_inkwell,  // the stylus is in its holder
  starting,    // the hand is not still yet, or the tool's weight or the maker's ramp still rises
  emergency,   // the emergency stop was pressed
  not_moved    // the program that moves the hand has given no pose for too long
};

/// A reading of a device.
struct DeviceReading {
  Pose pose;           // of the tool, world frame
  bool ok = true;      // false: the device has a fault; the servo gives zero force and reports it
  bool ended = false;  // no more readings will come (a recording is over)
  /// The person holds the enabling switch that lets the hand move a robot (docs/teleoperation.md).
  bool deadman = false;
  /// [m] the wanted opening of the robot's gripper, if the device has a lever for it.
  std::optional<double> gripper{};
  /// False: the device has no newer reading than the last one, and `pose` is not used. The
  /// servo makes no tick for it: the device keeps the held force, and write() is not called.
  bool fresh = true;
  /// The mean force on the hand since the last fresh reading, if the device knows that it differs
  /// from the force of write(): it applied the force late, or cut it. Absent: as write() gave.
  std::optional<Command> held{};
  /// The person holds the clutch button, which lifts the hand off the scene
  /// (client/device/mapped_device.hpp).
  bool clutch = false;
  /// The hand moves without the tool. The tool stands still, and no force is on the hand. The servo
  /// asks for no force, and the movement earns no energy.
  bool clutched = false;
  /// All buttons, a bit each; the first is bit 0.
  std::uint32_t buttons = 0;
  /// Whether no hand can have moved here (core/device/possible_movement.hpp), said by a driver that
  /// knows the times of its own positions. Absent: the servo judges by the times of its ticks.
  std::optional<bool> jumped{};
  /// Not `nothing`: the servo asks for no force, and the movement earns nothing. The pose is shown
  /// in the scene, unless the device is not homed.
  Withheld withheld = Withheld::nothing;
};

/// A haptic device. The servo thread calls read() and then write(), once each tick; no other thread
/// calls them. Neither may block, allocate or throw. The tick is the servo's own, or that of a
/// device which sets the pace: then await_tick() comes before read(), and may block.
class Device {
 public:
  virtual ~Device() = default;
  /// The specification. It must not change.
  virtual const DeviceSpec& spec() const = 0;

  /// Metres of the tool's way for one metre of the handle's (client/device/mapped_device.hpp). It
  /// must not change.
  virtual double motion_scale() const { return 1.0; }

  /// Called once, before the first read(), by the thread that joined. The arguments say where a
  /// hand that does not know the scene should begin: a point [m] on a surface and the unit normal
  /// there, world frame. Simulated hands go there; a real device can ignore it. If it throws, the
  /// run does not begin.
  virtual void begin(const Vec3& /*position*/, const Vec3& /*normal*/) {}

  /// Called before begin(), several times a second, until it returns an empty text: the device can
  /// give force. Else the text says what a person must do first. It may block for 10 ms.
  virtual std::string_view prepare() noexcept { return {}; }

  /// The longest time between two ticks that a device which sets the pace guarantees: the session's
  /// servo period T. Zero: it sets no pace, and the servo's own timer does. It must not change.
  virtual Nanoseconds longest_tick() const { return Nanoseconds(0); }

  /// Waits for the next tick of a device that sets the pace, until `latest` (a monotonic time) at
  /// most. False: none came by then, or none can come; the servo takes the force off.
  virtual bool await_tick(Nanoseconds /*latest*/) noexcept { return false; }

  /// Returns the pose of the tool at `now`, a monotonic time. A simulated device moves up to that
  /// time.
  virtual DeviceReading read(Nanoseconds now) noexcept = 0;

  /// Holds this command on the hand until the next write(). It is already within the spec's limits.
  /// Returns the command that is really held, which may be less (a fault, an amplifier's limit) or
  /// still the one before (a force that comes too late for this tick). Only this command is
  /// accounted for, unless the next reading has another held force. A device that takes forces up
  /// late (ActuationSpec::late_ticks) and cannot tell returns what it was given: then the command
  /// of so many ticks before is accounted for (client/device/command_delay.hpp).
  virtual Command write(const Command& on_hand) noexcept = 0;

  /// Called before each of the last ticks, when the servo's own force has faded: takes off slowly
  /// what the device holds by itself, the weight of a tool. True: nothing is left of it.
  virtual bool lower_tool(Nanoseconds /*now*/) noexcept { return true; }

  /// Takes the force off the hand for good. Later calls of write() must hold nothing. It is called
  /// when the run ends, when the servo thread makes no ticks, and when the program crashes. Any
  /// thread and any signal handler may call it, more than once, also while read() or write() runs
  /// in another thread or has crashed in this one. So it must be async-signal-safe
  /// (signal-safety(7)): no lock, no allocation, no waiting for read() or write(). A system call on
  /// the device's descriptor is fine, and so is an atomic flag that a thread of the driver acts on.
  virtual void release() noexcept = 0;
};

}  // namespace feltwire
