#pragma once
// Finds the gamepads and 3D mice that the kernel knows, and says what keeps each from being used.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/devices/event_node.hpp"
#include "client/devices/plugged_in.hpp"

namespace feltwire {

/// "gamepad" or "spacemouse" of --device, by what the input device has; empty: it is neither. A
/// gamepad has two axes and the lower button of its diamond; a 3D mouse has six axes and buttons
/// without a name. Neither is a keyboard, a flight stick, or a gamepad's gyroscope.
std::string_view input_kind(const InputKeys& keys, const InputAxes& axes,
                            const InputAxes& relative_axes) noexcept;

/// An event node of a gamepad or a 3D mouse.
struct InputNode {
  std::filesystem::path node;   // /dev/input/event5
  std::string name;             // that it calls itself
  std::string vendor, product;  // as udev compares them: "046d"
  std::string_view kind;
};

/// In the order of their numbers. What cannot be read is taken for not there.
std::vector<InputNode> input_nodes(const Machine& machine);

/// The udev rule that lets the user of the seat open it.
std::string input_rule(std::string_view vendor, std::string_view product);

/// What helps where a node may not be opened: the rule to paste, as far as the device is known.
std::string input_node_remedy(const Machine& machine, const std::filesystem::path& node);

}  // namespace feltwire
