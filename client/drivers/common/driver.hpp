#pragma once
// A kind of device for --device, and what a user asks of it.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/device/device.hpp"
#include "client/hands/hand_path.hpp"
#include "client/hands/true_energy.hpp"
#include "client/hands/wrist_path.hpp"
#include "client/input_devices/steering.hpp"
#include "core/device/device_file.hpp"

namespace feltwire {

/// Which device to open, and how.
struct DeviceRequest {
  std::string name;  // the part after the kind: --device KIND:NAME; empty: none
  SpecRequest spec;
  bool held = true;  // false: nobody holds the simulated handle
  HandTask task;     // of the simulated hand
  WristTask wrist;   // the wrist of the simulated hand, for a device that senses rotation
  bool own_center = true, own_normal = true;  // of the simulated hand; false: begin() gives them
  std::optional<double>
      leads_from;  // [s] time from which its switch is held; empty: it leads no robot
  std::optional<double> presses_at;  // [s] as SimulatedHandOptions::presses_at
  std::string firmware;              // file for a Falcon; empty: none
  SteeringOptions steering;          // of a gamepad or a 3D mouse
};

struct OpenedDevice {
  std::unique_ptr<Device> device;
  std::vector<std::string> notes;  // shown to the user once: assumptions, missing features
  /// SimulatedDevice::true_energy() of this device, while it lives; empty: it is not simulated.
  std::function<TrueEnergy()> true_energy{};
};

/// A kind of device. To add one: write a room beside this one, and an entry in drivers.cpp.
struct Driver {
  enum class Name { none, optional, required };
  std::string_view kind;  // the name on the command line, --device
  Name takes_name;        // whether a name may or must follow KIND:
  std::string_view name;  // the name as --help shows it: "FILE.csv"
  /// The file that the driver reads, from its name. Null: it reads none. Throws
  /// std::invalid_argument if the name is none that it knows.
  std::string (*file)(std::string_view name);
  std::string_view summary;  // a few words for --help
  std::string_view spec;     // the specification if neither the user nor the device gives one
  /// Throws std::runtime_error or std::invalid_argument with the error and the remedy.
  OpenedDevice (*open)(const DeviceRequest& request);
  /// "FILE, version 3.17.5": the maker's library or service that it needs; null: it needs none.
  /// Throws std::runtime_error that names the missing files, their places, and the remedy.
  std::string (*library)();
  bool held_by_person = true;   // a person's hand may hold it
  bool gives_force = true;      // false: `identify` cannot measure it
  bool takes_firmware = false;  // the setting firmware=FILE is for it
  int buttons = 0;              // number of its buttons that are read (DeviceReading::buttons)
  // Which of them the driver takes for the enabling switch and for the clutch, counted from 1. 0:
  // none, or one that is not among them.
  int deadman_button = 0, clutch_button = 0;
};

}  // namespace feltwire
