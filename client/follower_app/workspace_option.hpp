#pragma once
// A robot's own workspace on the command line.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/teleoperation/workspace.hpp"

namespace feltwire {

struct WorkspaceValues {
  std::optional<std::array<double, 6>> box;  // [m] low corner, high corner
  std::vector<std::string> keep_out;         // [m] X,Y,Z,HX,HY,HZ,R: middle, half extents, radius
  std::vector<std::string> lock;             // x, y, z, rotation
};

/// Throws std::invalid_argument that names the option and the remedy.
Workspace workspace_of(const WorkspaceValues& words);

}  // namespace feltwire
