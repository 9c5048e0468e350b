#pragma once
// The kinds of device that --device can name, and how each is opened.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/devices/device.hpp"
#include "client/devices/hand_path.hpp"
#include "client/devices/steering.hpp"
#include "client/devices/wrist_path.hpp"
#include "core/device/device_file.hpp"

namespace feltwire {

/// Which device to open, and how.
struct DeviceRequest {
  std::string name;  // what stands behind the kind: --device KIND:NAME; empty: nothing
  SpecRequest spec;
  bool held = true;                           // false: nobody holds the simulated handle
  HandTask task;                              // of the simulated hand
  WristTask wrist;                            // likewise, of a device that senses rotation
  bool own_center = true, own_normal = true;  // likewise; false: begin() says them
  std::optional<double> leads_from;           // [s] its switch is held; empty: it leads no robot
  SteeringOptions steering;                   // of a gamepad or a 3D mouse
};

struct OpenedDevice {
  std::unique_ptr<Device> device;
  std::vector<std::string> notes;  // what the user is told once: assumptions, what cannot be had
};

/// A kind of device. To add one: write its file beside this one, and an entry in drivers.cpp.
struct Driver {
  enum class Name { none, optional, required };
  std::string_view kind;     // as --device names it
  Name takes_name;           // whether something may or must stand behind KIND:
  std::string_view name;     // what that is, for people: "FILE.csv"
  bool names_file;           // it is a file, which is read
  std::string_view summary;  // a few words for --help
  std::string_view spec;     // specification where none is asked for and the device says none
  /// Throws std::runtime_error or std::invalid_argument that says what is wrong and the remedy.
  OpenedDevice (*open)(const DeviceRequest& request);
  /// "FILE, version 3.17.5": the maker's library or service that it needs; null: it needs none.
  /// Throws std::runtime_error that says what was looked for and where, and the remedy.
  std::string (*library)();
  bool held_by_person = true;  // a person's hand may be at it
  bool gives_force = true;     // false: there is nothing that `identify` could measure with
};

std::span<const Driver> drivers();

/// "KIND or KIND:NAME" of all drivers, each with its summary, for --help.
std::string driver_choices();

/// A driver and what stands behind its kind.
struct DriverChoice {
  const Driver* driver = nullptr;
  std::string name;
};

/// Of "KIND" or "KIND:NAME". Throws std::invalid_argument listing the kinds there are, or saying
/// that a name is missing, or is none of that kind's.
DriverChoice chosen_driver(std::string_view words);

}  // namespace feltwire
