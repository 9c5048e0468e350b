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

struct PluggedIn {
  std::string id;                            // "1451:0402" of USB
  std::string what;                          // for people, and what it calls itself
  std::string kind;                          // of --device; empty: there is no driver for it
  std::vector<std::filesystem::path> nodes;  // /dev/..., as the programs of this machine name them
  std::vector<Complaint> complaints;
};

/// Where to look. Tests have a made-up tree of /sys, /dev and /proc.
struct Machine {
  std::filesystem::path root = "/";
  /// Whether this user may read and write the file.
  std::function<bool(const std::filesystem::path&)> may_open = nullptr;  // null: asks the system
};

/// The devices on USB that a haptic device's maker is known to sell, in the order of the ports;
/// then the gamepads and 3D mice, wherever they are plugged in, in the order of their event nodes.
/// What cannot be read is taken for not there. Of other users' programs the system tells only root
/// what they hold.
std::vector<PluggedIn> plugged_in(const Machine& machine);

/// "openhaptics: Touch (2988:0302), /dev/ttyACM0" and below it each problem with its remedy.
std::string text(const std::vector<PluggedIn>& devices);

}  // namespace feltwire
