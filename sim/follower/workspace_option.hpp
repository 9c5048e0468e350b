#pragma once
// A robot's own workspace on the command line.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/teleoperation/workspace.hpp"

namespace feltwire {

struct WorkspaceWords {
  std::optional<std::array<double, 6>> box;     // [m] low corner, high corner
  std::vector<std::array<double, 7>> keep_out;  // [m] middle, half extents, radius of each
  std::vector<std::string> lock;                // x, y, z, rotation
};

/// Throws std::invalid_argument that names the option and the remedy.
Workspace workspace_of(const WorkspaceWords& words);

}  // namespace feltwire
