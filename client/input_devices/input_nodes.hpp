#pragma once
// Finds the gamepads and 3D mice that the kernel knows, and the reason why a program cannot use
// one.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/input_devices/event_node.hpp"
#include "client/input_devices/usb_scan.hpp"

namespace feltwire {

/// Returns "gamepad" or "spacemouse" (the kinds of --device), or an empty text for any other
/// device. A gamepad has two axes and the lower button of its diamond. A 3D mouse has six axes and
/// buttons without a name. A keyboard, a flight stick and a gamepad's gyroscope are neither.
std::string_view input_kind(const InputKeys& keys, const InputAxes& axes,
                            const InputAxes& relative_axes) noexcept;

/// An event node of a gamepad or a 3D mouse.
struct InputNode {
  std::filesystem::path node;   // /dev/input/event5
  std::string name;             // the name that the device reports
  std::string vendor, product;  // in the form that udev compares: "046d"
  std::string_view kind;
};

/// Returns the nodes in the order of their numbers. It leaves out nodes that it cannot read.
std::vector<InputNode> input_nodes(const Machine& machine);

/// Returns the udev rule that lets the user of the seat open the node.
std::string input_rule(std::string_view vendor, std::string_view product);

/// Returns the remedy for a node that may not be opened: the rule to paste, if the device is known.
std::string input_node_remedy(const Machine& machine, const std::filesystem::path& node);

}  // namespace feltwire
