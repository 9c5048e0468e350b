// The events of a scene's log other than the datagrams of its sessions, and their replay.

#include "core/base/splitmix.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {
namespace {

std::uint64_t digest_of(const Pose& pose) noexcept {
  const std::array<double, 7> numbers = {
      pose.position.x(),    pose.position.y(),    pose.position.z(),   pose.orientation.w(),
      pose.orientation.x(), pose.orientation.y(), pose.orientation.z()};
  return digest({reinterpret_cast<const std::uint8_t*>(numbers.data()), sizeof numbers});
}

}  // namespace

void SceneSessions::check(Nanoseconds now) noexcept {
  if (log_ == nullptr) return;
  std::uint64_t sum = 0;
  if (world_ != nullptr)
    for (std::size_t i = world_->view().still(); i < world_->objects().size(); ++i)
      sum = splitmix::mix(sum + digest_of(world_->objects()[i].pose));
  log({.kind = EventKind::check, .time = now, .digest = sum});
}

void SceneSessions::replay_end(std::uint64_t id, SessionEnd how) noexcept {
  if (SessionSlot** slot = by_id_.find(id)) end(**slot, how);
}

}  // namespace feltwire
