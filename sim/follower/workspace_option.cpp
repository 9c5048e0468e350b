#include "sim/follower/workspace_option.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

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

/// The seven numbers of `words`, with commas between them; none where it is anything else.
std::optional<KeepOutBody> body_of(std::string_view words) {
  std::array<double, 7> b{};
  const char* at = words.data();
  const char* const end = at + words.size();
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (i > 0 && (at == end || *at++ != ',')) return std::nullopt;
    const auto read = std::from_chars(at, end, b[i]);
    if (read.ec != std::errc{}) return std::nullopt;
    at = read.ptr;
  }
  const KeepOutBody body{
      {Vec3(b[0], b[1], b[2]), Quaternion::Identity()}, Vec3(b[3], b[4], b[5]), b[6]};
  if (at != end || !body.valid(Workspace::kFarthest)) return std::nullopt;
  return body;
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
