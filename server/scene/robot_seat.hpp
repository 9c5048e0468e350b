#pragma once

#include <optional>

#include "core/teleoperation/workspace.hpp"
#include "server/scene/session_slot.hpp"
#include "server/scene/teleop_link.hpp"
#include "server/scene/world_arm.hpp"

namespace feltwire {

/// A seat of a scene for a robot.
struct RobotSeat {
  TeleopLink link;
  SessionSlot* robot = nullptr;      // who sits there
  Workspace own = {};                // the robot's own
  std::optional<WorldArm> arm = {};  // the robot is of the world, and sits there always
};

}  // namespace feltwire
