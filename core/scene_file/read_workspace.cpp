#include "core/scene_file/read_workspace.hpp"

#include <cmath>
#include <utility>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr const char* kTooFar = "is farther than 1000 m from the robot's origin; move it";

void read_box(const JsonDocument& document, const std::string& path,
              const scene_file::Workspace& from, Workspace& to) {
  if (from.low() == nullptr && from.high() == nullptr) return;
  for (const auto& [name, corner] : {std::pair{".low", from.low()}, {".high", from.high()}}) {
    if (corner == nullptr)
      document.fail(path + name, "is missing; a box has both corners, low and high");
    if (!(vector(*corner).cwiseAbs().maxCoeff() <= Workspace::kFarthest))
      document.fail(path + name, kTooFar);
  }
  const Vec3 low = vector(*from.low()), high = vector(*from.high());
  if (!(low.array() < high.array()).all())
    document.fail(path + ".high", "must be above low on each axis; exchange or move them");
  to.add_box(low, high);
}

WorkspaceWall read_wall(const JsonDocument& document, const std::string& path,
                        const scene_file::WorkspaceWall& from) {
  Start plane;
  if (const auto* p = from.position()) plane.position = vector(*p);
  if (const auto* n = from.normal()) plane.normal = vector(*n);
  require(document, path, check(plane));
  const Vec3 normal = direction(plane.normal);
  const double distance = normal.dot(plane.position);
  if (!(std::abs(distance) <= Workspace::kFarthest)) document.fail(path + ".position", kTooFar);
  return {normal, distance};
}

KeepOutBody read_body(const JsonDocument& document, const std::string& path,
                      const scene_file::KeepOutBody& from) {
  KeepOutBody body;
  body.pose = pose_of(from);
  if (const auto* size = from.size()) body.half = 0.5 * vector(*size);
  body.radius = from.radius();
  require(document, path, check(body));
  make_unit(body.pose.orientation);
  return body;
}

}  // namespace

void read_workspace(const JsonDocument& document, const std::string& path,
                    const scene_file::Workspace& from, RemoteSeat& seat) {
  Workspace& to = seat.workspace;
  read_box(document, path, from, to);
  if (const auto* walls = from.walls()) {
    if (to.count + walls->size() > Workspace::kMostGiven)
      document.fail(path + ".walls",
                    "has more than 16 walls with those of the box; leave out "
                    "those that no target would reach");
    for (flatbuffers::uoffset_t i = 0; i < walls->size(); ++i)
      to.add(read_wall(document, path + "." + element("walls", i), *walls->Get(i)));
  }
  if (const auto* bodies = from.keep_out()) {
    if (bodies->size() > Workspace::kMostBodiesGiven)
      document.fail(path + ".keep_out", "has more than 8 bodies; put a larger one around several");
    for (flatbuffers::uoffset_t i = 0; i < bodies->size(); ++i)
      to.add_body(read_body(document, path + "." + element("keep_out", i), *bodies->Get(i)));
  }
  if (const auto* lock = from.lock())
    for (const auto axis : *lock) {
      if (axis == scene_file::LockedAxis::rotation)
        to.turning_locked = true;
      else
        to.locked[static_cast<std::size_t>(axis)] = true;
    }
  seat.wall_stiffness = from.stiffness();
  seat.wall_depth = from.depth();
}

}  // namespace feltwire
