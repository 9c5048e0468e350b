#pragma once
// Finds the connected devices that feltwire knows, and the problems that keep each from being
// used.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace feltwire {

/// A problem and its remedy.
struct Complaint {
  std::string problem, remedy;
};

struct ConnectedDevice {
  std::string id;                            // "1451:0402" of USB
  std::string what;                          // for people, with the name that the device reports
  std::string kind;                          // of --device; empty: there is no driver for it
  std::vector<std::filesystem::path> nodes;  // /dev/..., as the programs of this machine name them
  std::vector<Complaint> complaints;
};

/// The place to search. Tests have a made-up tree of /sys, /dev and /proc.
struct Machine {
  std::filesystem::path root = "/";
  /// Returns whether this user may read and write the file.
  std::function<bool(const std::filesystem::path&)> may_open = nullptr;  // null: asks the system
};

/// Returns the USB devices that a maker of haptic devices is known to sell, in the order of the
/// ports. After them come the gamepads and 3D mice of every port, in the order of their event
/// nodes. It leaves out devices that it cannot read. Only root can see which programs of other
/// users hold a node.
std::vector<ConnectedDevice> scan_usb(const Machine& machine);

/// Returns "openhaptics: Touch (2988:0302), /dev/ttyACM0" and below it each problem with its
/// remedy.
std::string text(const std::vector<ConnectedDevice>& devices);

}  // namespace feltwire
