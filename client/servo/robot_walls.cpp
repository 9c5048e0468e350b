#include "client/servo/robot_walls.hpp"

#include <algorithm>

namespace feltwire {
namespace {

constexpr double kReach = 1.0;  // [m] smallest radius of a wall's patch

}  // namespace

void RobotWalls::clear() noexcept {
  springs_.clear();
  weight_ = 0.0;
  count_ = 0;
}

bool RobotWalls::reach(const Vec3& wanted, std::span<const RemoteWall> walls) noexcept {
  return std::ranges::any_of(
      walls, [&](const RemoteWall& w) { return w.wall.clearance(wanted) < w.depth; });
}

/// Returns the slack of a wall, the penetration up to which it gives no force. The slack of a new
/// wall is its whole penetration `pressed`.
double RobotWalls::slack_of(const RemoteWall& wall, double pressed) const noexcept {
  const auto known =
      std::ranges::find(slacks_.begin(), slacks_.begin() + count_, wall.number, &Slack::number);
  return known == slacks_.begin() + count_ ? pressed : known->way;
}

void RobotWalls::step(const Vec3& hand, std::span<const RemoteWall> told, SurfaceOffset& index,
                      double elapsed) noexcept {
  if (told.empty()) {
    weight_ = std::max(0.0, weight_ - elapsed / fade_);
    count_ = 0;
    if (weight_ == 0.0) springs_.clear();
    return;
  }
  weight_ = 1.0;
  const auto walls = told.first(std::min<std::size_t>(told.size(), kMostRemoteWalls));
  std::array<WorkspaceWall, kMostRemoteWalls> planes;
  std::ranges::transform(walls, planes.begin(), &RemoteWall::wall);
  const Vec3 before = index.offset();
  index.keep_in_front(hand, {planes.data(), walls.size()});
  const Vec3 taken_along = index.offset() - before;

  std::array<Slack, kMostRemoteWalls> slacks;
  LocalModel model;
  model.center = hand;
  for (const RemoteWall& w : walls) {
    const double clearance = w.wall.clearance(hand - index.offset());
    const double pressed = std::max(0.0, w.depth - clearance);
    const double pushed = std::max(0.0, -taken_along.dot(w.wall.normal));
    const double slack = std::clamp(slack_of(w, pressed) - pushed, 0.0, pressed);
    const auto at = static_cast<std::size_t>(model.count++);
    slacks[at] = {w.number, slack};
    SurfacePatch& patch = model.patches[at];
    const double above = clearance - (w.depth - slack);
    patch.normal = w.wall.normal;
    patch.point = hand - above * patch.normal;
    patch.radius = kReach + std::abs(above);
    patch.material.stiffness = w.stiffness;
    patch.feature = w.number;
    model.reach = std::max(model.reach, patch.radius);
  }
  slacks_ = slacks;
  count_ = walls.size();
  springs_.take(model);
}

Vec3 RobotWalls::push(const Tool& tool, double elapsed) noexcept {
  if (!(weight_ > 0.0)) return Vec3::Zero();
  return weight_ * springs_.touch(tool, 0.0, elapsed).command.force();
}

}  // namespace feltwire
