#include "client/follower_app/workspace_option.hpp"

#include <cmath>
#include <stdexcept>
#include <string_view>

#include "core/base/number_list.hpp"

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

/// Returns the body that "X,Y,Z,HX,HY,HZ,R" describes, or nothing for any other text.
std::optional<KeepOutBody> body_of(std::string_view text) {
  std::array<double, 7> b{};
  if (!numbers_of(text, b, Workspace::kFarthest)) return std::nullopt;
  const KeepOutBody body{
      {Vec3(b[0], b[1], b[2]), Quaternion::Identity()}, Vec3(b[3], b[4], b[5]), b[6]};
  return body.valid(Workspace::kFarthest) ? std::optional(body) : std::nullopt;
}

}  // namespace

Workspace workspace_of(const WorkspaceValues& words) {
  Workspace workspace;
  if (words.box) {
    const auto& b = *words.box;
    for (std::size_t axis = 0; axis < 3; ++axis)
      // Each of these comparisons is false for NaN, so the condition rejects NaN.
      if (!(b[axis] < b[axis + 3] && std::abs(b[axis]) <= Workspace::kFarthest &&
            std::abs(b[axis + 3]) <= Workspace::kFarthest))
        throw std::invalid_argument(
            "--workspace must be six numbers within 1000 m, X0,Y0,Z0,X1,Y1,Z1, the first three "
            "below the last three on each axis");
    workspace.add_box(Vec3(b[0], b[1], b[2]), Vec3(b[3], b[4], b[5]));
  }
  if (words.keep_out.size() > Workspace::kMostBodiesGiven)
    throw std::invalid_argument("--keep-out is given " + std::to_string(words.keep_out.size()) +
                                " times; give it 8 times at most");
  for (const std::string& text : words.keep_out) {
    const std::optional<KeepOutBody> body = body_of(text);
    if (!body)
      throw std::invalid_argument(
          "--keep-out must be seven numbers within 1000 m, X,Y,Z,HX,HY,HZ,R: half extents of 0 or "
          "more, and a radius R of 0.001 or more; it is '" +
          text + "'");
    workspace.add_body(*body);
  }
  for (const std::string& axis : words.lock) lock(workspace, axis);
  return workspace;
}

}  // namespace feltwire
