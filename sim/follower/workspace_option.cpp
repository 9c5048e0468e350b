#include "sim/follower/workspace_option.hpp"

#include <cmath>
#include <stdexcept>

namespace feltwire {
namespace {

void lock(Workspace& workspace, const std::string& axis) {
  if (axis == "x" || axis == "y" || axis == "z")
    workspace.locked[static_cast<std::size_t>(axis[0] - 'x')] = true;
  else if (axis == "rotation")
    workspace.turning_locked = true;
  else
    throw std::invalid_argument("--lock: there is no axis '" + axis +
                                "'; give some of x, y, z, rotation, with commas between them");
}

}  // namespace

Workspace workspace_of(const WorkspaceWords& words) {
  Workspace workspace;
  if (words.box) {
    const auto& b = *words.box;
    for (std::size_t axis = 0; axis < 3; ++axis)
      // Written so that NaN fails.
      if (!(b[axis] < b[axis + 3] && std::abs(b[axis]) <= Workspace::kFarthest &&
            std::abs(b[axis + 3]) <= Workspace::kFarthest))
        throw std::invalid_argument(
            "--workspace must be six numbers within 1000 m, X0,Y0,Z0,X1,Y1,Z1, the first three "
            "below the last three on each axis");
    workspace.add_box(Vec3(b[0], b[1], b[2]), Vec3(b[3], b[4], b[5]));
  }
  for (const std::string& axis : words.lock) lock(workspace, axis);
  return workspace;
}

}  // namespace feltwire
